#include "runtime/world/graph/write.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "runtime/base/csv_row.h"

namespace meld::graph {
namespace {

Result<std::string> cell(std::string_view word) {
    if (word.find_first_of("\r\n") != std::string_view::npos)
        return fail(fmt::format("'{}' has a line break, and a field of a list of links or nodes has none",
                                word.substr(0, word.find_first_of("\r\n"))),
                    "replace it in the file that the graph comes from");
    return csv_field(word);
}

Result<std::string> names(std::string line, const std::vector<const Column*>& columns) {
    for (const Column* column : columns) {
        const Result<std::string> name = cell(column->name);
        if (!name) return name;
        line += "," + *name;
    }
    return line + "\n";
}

// A number as it is read again with the same type.
Result<std::string> values(std::string line, const std::vector<const Column*>& columns, std::size_t row) {
    for (const Column* column : columns) {
        const auto* const words = std::get_if<std::vector<std::string>>(&column->values);
        const Result<std::string> value = words != nullptr ? cell((*words)[row]) : Result<std::string>(column->text(row));
        if (!value) return value;
        line += "," + *value;
    }
    return line + "\n";
}

std::vector<const Column*> pointers(const std::vector<Column>& columns) {
    std::vector<const Column*> out;
    for (const Column& column : columns) out.push_back(&column);
    return out;
}

}  // namespace

Result<void> write_links(const Graph& graph, const Put& put) {
    const std::vector<const Column*> columns = pointers(graph.columns);
    const Result<std::string> first = names("from,to", columns);
    if (!first) return tl::unexpected<Error>(first.error());
    put(*first);
    for (Node node = 0; node < graph.nodes(); ++node)
        for (std::uint64_t at = graph.first[node]; at < graph.first[node + 1]; ++at) {
            if (graph.directed ? !graph.leads(at) : graph.to[at] < node) continue;
            const Result<std::string> line =
                values(fmt::format("{},{}", graph.id(node), graph.id(graph.to[at])), columns, graph.row.empty() ? 0 : graph.row[at]);
            if (!line) return tl::unexpected<Error>(line.error());
            put(*line);
        }
    return {};
}

Result<void> write_nodes(const Graph& graph, const Put& put) {
    std::vector<const Column*> columns = pointers(graph.node_columns);
    // Places are columns of the file, or follow from the links, or are those of a generator.
    const bool has_x = std::ranges::any_of(columns, [](const Column* c) { return c->name == "x" || c->name == "y"; });
    Column x{.name = "x"}, y{.name = "y"}, z{.name = "z"};
    if (!has_x && !graph.places.empty()) {
        std::vector<double> xs, ys, zs;
        for (const Point& place : graph.places) xs.push_back(place[0]), ys.push_back(place[1]), zs.push_back(place[2]);
        const bool flat = std::ranges::all_of(zs, [](double each) { return each == 0; });
        x.values = std::move(xs), y.values = std::move(ys), z.values = std::move(zs);
        columns.insert(columns.begin(), {&x, &y});
        if (!flat) columns.insert(columns.begin() + 2, &z);
    }
    const Result<std::string> first = names("node", columns);
    if (!first) return tl::unexpected<Error>(first.error());
    put(*first);
    for (Node node = 0; node < graph.nodes(); ++node) {
        const Result<std::string> line = values(fmt::format("{}", graph.id(node)), columns, node);
        if (!line) return tl::unexpected<Error>(line.error());
        put(*line);
    }
    return {};
}

}  // namespace meld::graph
