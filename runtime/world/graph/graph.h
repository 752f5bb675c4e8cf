// A graph: nodes, and for each node its neighbours in ascending order. It knows nothing of programs.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace meld::graph {

// 0 .. nodes - 1. Nodes may have other numbers outside, see Graph::id().
using Node = std::uint32_t;
// Of a link as it was listed.
using Row = std::uint32_t;
inline constexpr Row kNoRow = std::numeric_limits<Row>::max();
// Indices of catoms have 31 bits; so do those of the library that divides graphs.
inline constexpr std::uint64_t kMaxNodes = std::uint64_t{1} << 30;

struct Link {
    Node from = 0, to = 0;
};

// In catom diameters. Flat layouts have z = 0.
using Point = std::array<double, 3>;

// What a file says about each link besides its ends, or about each node.
struct Column {
    std::string name;
    std::variant<std::vector<std::int64_t>, std::vector<double>, std::vector<std::string>> values = {};
    // The value as a literal of the language.
    std::string text(std::size_t row) const;
    bool same(std::size_t a, std::size_t b) const;
    std::size_t size() const;
};

struct Graph {
    bool directed = false;
    // first[n] .. first[n + 1] are the links of node n. Each link is in there twice, once for each end, whatever its direction.
    std::vector<std::uint64_t> first{0};
    std::vector<Node> to;
    // For each of these the row that lists it in this direction, or kNoRow. Empty if the graph is undirected and has no columns.
    std::vector<Row> row = {};
    std::vector<Column> columns = {};       // By row.
    std::vector<Column> node_columns = {};  // By node.
    // The numbers of the nodes, ascending; empty if these are 0, 1, 2, ...
    std::vector<std::uint64_t> ids = {};
    std::vector<Point> places = {};  // By node, if they are known.
    // What is doubtful about the files, as sentences without a full stop.
    std::vector<std::string> warnings = {};

    std::uint64_t nodes() const { return first.size() - 1; }
    std::uint64_t links() const { return to.size() / 2; }
    std::span<const Node> neighbours(Node node) const { return {to.data() + first[node], first[node + 1] - first[node]}; }
    std::uint64_t degree(Node node) const { return first[node + 1] - first[node]; }
    // Whether a link leads in the direction of entry `at` of `to`. In an undirected graph each does, in both.
    bool leads(std::uint64_t at) const { return row.empty() || row[at] != kNoRow; }
    std::uint64_t id(Node node) const { return ids.empty() ? node : ids[node]; }
    // The node with this number. Cost: a binary search, or none if the numbers are 0, 1, 2, ...
    std::optional<Node> find(std::uint64_t id) const;
    // One more than the greatest number of a node.
    std::uint64_t next_id() const { return nodes() == 0 ? 0 : id(static_cast<Node>(nodes() - 1)) + 1; }
    // Of all that decides about a run. Processes compare it.
    std::uint64_t hash() const;
};

// What became of a list of links.
struct Made {
    Graph graph;
    std::uint64_t loops = 0, doubled = 0;
    Row first_loop = kNoRow, first_doubled = kNoRow;
    // Two rows that list the same link, and a column in which they differ.
    struct Conflict {
        Row first = 0, second = 0;
        std::size_t column = 0;
    };
    std::optional<Conflict> conflict = {};
};

// The graph of these links. A link of a node with itself is left out, and a link that is listed again, in an undirected graph also in the
// other direction, counts once; both are counted in the result. Nodes are below `nodes`. Cost: linear in nodes and links, and at most 24
// bytes a link beside the result.
Made make(std::uint64_t nodes, std::vector<Link> links, bool directed = false, std::vector<Column> columns = {});

// The number of pieces that are not linked with each other. Cost: linear.
std::uint64_t components(const Graph& graph);

struct Degrees {
    std::uint64_t least = 0, most = 0;
    double mean = 0;
};
Degrees degrees(const Graph& graph);

}  // namespace meld::graph
