// Graphs in files of other programs.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "runtime/base/error.h"
#include "runtime/base/process/available_memory.h"
#include "runtime/world/graph/graph.h"
#include "runtime/world/graph/table.h"

namespace meld::graph {

struct FileText {
    std::string path;
    std::string_view text;
};

// The graph of a file with links, by the ending of its name: .mtx (Matrix Market), .json (node-link form of networkx), otherwise a list
// with a line for each link, whose fields are separated by commas, semicolons, tabs or blanks. `nodes` is a list of nodes, for which the
// first field is the node and the others are columns. Errors name file and line; `room` has no place for the graph. Cost: linear in the
// text.
Result<Graph> read_graph(const FileText& links, const std::optional<FileText>& nodes, std::optional<bool> directed,
                         const MemoryLimit& room = {});

// A list with the nodes 0 .. nodes - 1, linked or not.
Result<Graph> read_graph(const FileText& list, std::uint64_t nodes, std::optional<bool> directed, const MemoryLimit& room = {});

// Nodes with places, the columns x, y and perhaps z, and without links. The first column is the node, or x: then nodes are numbered in the
// order of the lines. Errors as above; there are no places.
Result<Graph> read_points(const FileText& nodes, const MemoryLimit& room = {});

// ---- by form
// A line for each link: its two ends and further columns. Lines that begin with # or % and empty lines are skipped; a first line of words
// before numbers, or of well-known names, names the columns.
Result<Table> read_list(const FileText& file);
// Adds nodes and their columns; all nodes of the links must be among them.
Result<void> read_nodes(const FileText& file, Table& table);
// Row i is node i - 1. A `general` matrix says nothing of directions.
Result<Table> read_matrix_market(const FileText& file);
Result<Table> read_node_link(const FileText& file);

}  // namespace meld::graph
