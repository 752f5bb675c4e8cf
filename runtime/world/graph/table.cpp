#include "runtime/world/graph/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "runtime/base/release_memory.h"
#include "runtime/world/graph/memory_check.h"

namespace meld::graph {
namespace {

// Numbers with few gaps are counted in an array, others are sorted.
constexpr std::uint64_t kDense = 16;

// All numbers of nodes, ascending, each once.
std::vector<std::uint64_t> numbers_of(const Table& table) {
    std::uint64_t most = table.node_count;
    for (const Ends& ends : table.ends) most = std::max({most, ends.from + 1, ends.to + 1});
    for (const std::uint64_t node : table.nodes) most = std::max(most, node + 1);
    std::vector<std::uint64_t> out;
    if (most <= kDense * (2 * table.ends.size() + table.nodes.size() + table.node_count + 64)) {
        std::vector<bool> seen(most);
        for (std::uint64_t n = 0; n < table.node_count; ++n) seen[n] = true;
        for (const Ends& ends : table.ends) seen[ends.from] = seen[ends.to] = true;
        for (const std::uint64_t node : table.nodes) seen[node] = true;
        for (std::uint64_t n = 0; n < most; ++n)
            if (seen[n]) out.push_back(n);
        return out;
    }
    out.reserve(2 * table.ends.size() + table.nodes.size());
    for (const Ends& ends : table.ends) out.insert(out.end(), {ends.from, ends.to});
    out.insert(out.end(), table.nodes.begin(), table.nodes.end());
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
}

// A column of nodes in the order of the graph.
Column reordered(const Column& column, const std::vector<Node>& node_of_row, std::size_t nodes) {
    Column out{.name = column.name};
    std::visit(
        [&](const auto& values) {
            std::decay_t<decltype(values)> in_order(nodes);
            for (std::size_t row = 0; row < values.size(); ++row) in_order[node_of_row[row]] = values[row];
            out.values = std::move(in_order);
        },
        column.values);
    return out;
}

void take_places(Graph& graph) {
    const auto numbers = [&](std::string_view name) -> std::optional<std::vector<double>> {
        for (const Column& column : graph.node_columns) {
            if (column.name != name) continue;
            if (const auto* doubles = std::get_if<1>(&column.values)) return *doubles;
            if (const auto* integers = std::get_if<0>(&column.values)) return std::vector<double>(integers->begin(), integers->end());
        }
        return std::nullopt;
    };
    const auto x = numbers("x"), y = numbers("y"), z = numbers("z");
    if (!x || !y) return;
    graph.places.resize(graph.nodes());
    for (std::size_t i = 0; i < graph.places.size(); ++i) graph.places[i] = {(*x)[i], (*y)[i], z ? (*z)[i] : 0};
}

}  // namespace

std::uint64_t Names::number_of(std::string_view word) {
    const auto [at, added] = numbers_.try_emplace(std::string(word), words_.size());
    if (added) words_.emplace_back(word);
    return at->second;
}

std::optional<std::uint64_t> Names::find(std::string_view word) const {
    const auto at = numbers_.find(std::string(word));
    return at == numbers_.end() ? std::nullopt : std::optional(at->second);
}

void Table::add(std::uint64_t from, std::uint64_t to, std::uint64_t line) {
    const auto row = static_cast<Row>(ends.size());
    if (lines.empty() || line != lines.back().second + (row - lines.back().first)) lines.emplace_back(row, line);
    ends.push_back({from, to});
}

std::string Table::place(Row row) const {
    if (!has_lines) return fmt::format("{}: link {}", path, row);
    const auto after = std::upper_bound(lines.begin(), lines.end(), row, [](Row r, const auto& each) { return r < each.first; });
    return fmt::format("{}:{}", path, std::prev(after)->second + (row - std::prev(after)->first));
}

Result<Graph> graph_of(Table table, std::optional<bool> directed, const MemoryLimit& room) {
    if (table.ends.size() >= kNoRow)
        return fail(fmt::format("{} lists {} links, and there may be {}", table.path, table.ends.size(), kNoRow - 1));
    // A line may say that there are nodes without links, as many as it likes.
    const double all = static_cast<double>(std::max<std::uint64_t>(table.node_count, table.nodes.size()));
    const double links_listed = static_cast<double>(table.ends.size());
    if (const auto fits = check_memory(table.path, all, links_listed, kMaking_node * all + kMaking_link * links_listed, room); !fits)
        return tl::unexpected<Error>(fits.error());
    std::vector<std::uint64_t> numbers = numbers_of(table);
    if (numbers.size() > kMaxNodes) return fail(fmt::format("{} has {} nodes, and there may be {}", table.path, numbers.size(), kMaxNodes));
    if (numbers.empty() && table.nodes_listed) return fail(table.path + " lists no nodes", "write a line for each");
    if (numbers.empty()) return fail(table.path + " lists no links", "write a line with two nodes for each link");
    const bool dense = numbers.back() + 1 == numbers.size();
    // The node of a number, by an array where that is small.
    std::vector<Node> node_of;
    if (!dense && numbers.back() < kDense * 4 * numbers.size() + 1024) {
        node_of.resize(numbers.back() + 1);
        for (Node node = 0; node < numbers.size(); ++node) node_of[numbers[node]] = node;
    }
    const auto node = [&](std::uint64_t number) {
        if (dense) return static_cast<Node>(number);
        if (!node_of.empty()) return node_of[number];
        return static_cast<Node>(std::lower_bound(numbers.begin(), numbers.end(), number) - numbers.begin());
    };
    std::vector<Link> links;
    links.reserve(table.ends.size());
    for (const Ends& ends : table.ends) links.push_back({node(ends.from), node(ends.to)});
    release_memory(table.ends);

    Made made = make(numbers.size(), std::move(links), directed.value_or(table.directed.value_or(false)), std::move(table.columns));
    Graph& graph = made.graph;
    if (made.conflict) {
        const std::string& name = graph.columns[made.conflict->column].name;
        return fail(fmt::format("{}: this link is listed in {} already, with another {}", table.place(made.conflict->second),
                                table.place(made.conflict->first), name),
                    graph.directed ? "take one of them out"
                                   : "take one of them out, or write directed = true if the two directions of a link differ");
    }
    if (made.loops > 0)
        graph.warnings.push_back(
            fmt::format("{}: {} a node with itself and {} left out", table.place(made.first_loop),
                        made.loops == 1 ? "this link joins" : fmt::format("this and {} more links join", made.loops - 1),
                        made.loops == 1 ? "is" : "are"));
    if (made.doubled > 0)
        graph.warnings.push_back(fmt::format("{}: {} of {} links are listed more than once and count once", table.path, made.doubled,
                                             graph.links() + made.doubled));
    if (!dense) graph.ids = std::move(numbers);
    if (table.nodes_listed && table.nodes.size() == graph.nodes()) {
        std::vector<Node> node_of_row;
        for (const std::uint64_t number : table.nodes) node_of_row.push_back(node(number));
        for (const Column& column : table.node_columns) graph.node_columns.push_back(reordered(column, node_of_row, graph.nodes()));
    }
    if (table.names.words()) graph.node_columns.push_back({.name = "name", .values = table.names.all()});
    take_places(graph);
    return std::move(made.graph);
}

}  // namespace meld::graph
