// Nodes and links as files list them, on the way to a graph.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/base/process/available_memory.h"
#include "runtime/world/graph/graph.h"

namespace meld::graph {

// Numbers of nodes are ints of the language, and so is the next one after them.
inline constexpr std::uint64_t kMaxNumber = std::numeric_limits<std::int64_t>::max() - 1;

// Numbers stay what they are. Words get the numbers 0, 1, 2, ... in the order in which they appear.
class Names {
  public:
    std::uint64_t number_of(std::string_view word);
    std::optional<std::uint64_t> find(std::string_view word) const;
    bool words() const { return !words_.empty(); }
    const std::vector<std::string>& all() const { return words_; }

  private:
    std::vector<std::string> words_;
    std::unordered_map<std::string, std::uint64_t> numbers_;
};

struct Ends {
    std::uint64_t from = 0, to = 0;
};

struct Table {
    std::string path;
    std::vector<Ends> ends;
    // The line of each link where that is more than a number of lines before the first: lines without links are rare.
    std::vector<std::pair<Row, std::uint64_t>> lines;
    std::vector<Column> columns;
    std::optional<bool> directed;  // If the file says so.
    Names names;
    // Nodes that are there without a link too, if the file lists them.
    std::vector<std::uint64_t> nodes;
    bool nodes_listed = false;
    // All numbers up to this one are nodes, if the file says how many there are.
    std::uint64_t node_count = 0;
    std::vector<Column> node_columns;  // By `nodes`.

    void add(std::uint64_t from, std::uint64_t to, std::uint64_t line);
    // "links.csv:12" or, where the file has no lines, "links.json: link 12".
    std::string place(Row row) const;
    bool has_lines = true;
};

// The graph of a table; `directed` of the world comes before that of the file. Errors: two rows list a link with different values; `room`
// has no place for the graph.
Result<Graph> graph_of(Table table, std::optional<bool> directed, const MemoryLimit& room = {});

}  // namespace meld::graph
