#include "runtime/world/file/graph_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "runtime/world/description/point_sight.h"
#include "runtime/world/file/point_section.h"
#include "runtime/world/file/world_file.h"
#include "runtime/world/graph/cycle.h"
#include "runtime/world/graph/files.h"
#include "runtime/world/graph/generate.h"
#include "runtime/world/graph/layout.h"
#include "runtime/world/graph/range.h"

namespace meld::world {
namespace {

// Sections and keys of bodies and cells, and what to do instead.
constexpr std::pair<std::string_view, std::string_view> kNotInGraphs[] = {
    {"body", "a graph has nodes instead of cells: take [[body]] out"},
    {"target", "a target is a set of cells: take [target] out, or give a fact to the nodes that you mean"},
    {"without", "a graph has nodes instead of cells: take [without] out"},
    {"held", "nodes of a graph hold no units: take held out"},
};

// links = [[0, 1], [1, 2]], as the text of a file, and the greatest number in it; nothing if it is something else.
std::optional<std::string> pairs(const toml::node& links, std::int64_t& greatest) {
    std::string text;
    const toml::array* const rows = links.as_array();
    if (rows == nullptr) return std::nullopt;
    for (const toml::node& row : *rows) {
        const toml::array* const pair = row.as_array();
        if (pair == nullptr || pair->size() != 2) return std::nullopt;
        for (const std::size_t end : {0U, 1U}) {
            const auto node = pair->get(end)->value_exact<std::int64_t>();
            if (!node || *node < 0) return std::nullopt;
            greatest = std::max(greatest, *node);
            text += fmt::format("{}{}", *node, end == 0 ? "," : "\n");
        }
    }
    return text;
}

// nodes = [3, 7], as the text of a file; nothing if it is something else.
std::optional<std::string> numbers(const toml::node& nodes) {
    std::string text;
    const toml::array* const listed = nodes.as_array();
    if (listed == nullptr) return std::nullopt;
    for (const toml::node& each : *listed) {
        const auto node = each.value_exact<std::int64_t>();
        if (!node || *node < 0) return std::nullopt;
        text += fmt::format("{}\n", *node);
    }
    return text;
}

// Links that stand in the world itself; nodes = 12: these and all others of @0 to @11; nodes = [3, 7]: these.
Result<graph::Graph> read_pairs(TomlReader& reader, const Section& top, std::optional<bool> directed, const MemoryLimit& room) {
    const toml::node& links = *top.find("links");
    std::int64_t greatest = 0;
    const std::optional<std::string> text = pairs(links, greatest);
    if (!text) return fail("links are pairs of numbers", "write links = [[0, 1], [1, 2]], or name a file: links = \"edges.csv\"");
    const graph::FileText link_text{reader.place(links.source()), *text};
    if (!top.has("nodes")) return graph::read_graph(link_text, std::nullopt, directed, room);
    const toml::node& nodes = *top.find("nodes");
    if (nodes.is_array()) {
        const std::optional<std::string> listed = numbers(nodes);
        if (!listed || listed->empty()) return fail("nodes are numbers", "write nodes = [0, 3, 7], or how many there are: nodes = 8");
        return graph::read_graph(link_text, graph::FileText{reader.place(nodes.source()), *listed}, directed, room);
    }
    std::uint64_t count = 0;
    top.read_count("nodes", count, 1, graph::kMaxNodes);
    if (count <= static_cast<std::uint64_t>(greatest))
        return fail(fmt::format("the links name @{}, and the nodes are @0 to @{}", greatest, count - 1),
                    static_cast<std::uint64_t>(greatest) < graph::kMaxNodes ? fmt::format("write nodes = {}", greatest + 1)
                                                                            : "number nodes from 0");
    return graph::read_graph(link_text, count, directed, room);
}

Result<graph::Graph> read_files(TomlReader& reader, const Section& top, std::optional<bool> directed, const MemoryLimit& room) {
    if (!top.find("links")->is_string()) return read_pairs(reader, top, directed, room);
    std::string links, nodes;
    top.read("links", links);
    top.read("nodes", nodes);
    graph::FileText link_file{reader.beside(links), {}};
    const Result<std::string> link_text = reader.read_file(link_file.path, kMaxGraph_bytes);
    if (!link_text) return tl::unexpected<Error>(link_text.error());
    link_file.text = *link_text;
    if (!top.has("nodes")) return graph::read_graph(link_file, std::nullopt, directed, room);
    graph::FileText node_file{reader.beside(nodes), {}};
    const Result<std::string> node_text = reader.read_file(node_file.path, kMaxGraph_bytes);
    if (!node_text) return tl::unexpected<Error>(node_text.error());
    node_file.text = *node_text;
    return graph::read_graph(link_file, node_file, directed, room);
}

// acyclic = true: no way along the links leads back to where it began.
Result<void> check_acyclic(const graph::Graph& graph) {
    if (!graph.directed) return fail("links of a graph without directions lead there and back", "add directed = true, or take acyclic out");
    std::vector<graph::Node> circle = graph::cycle(graph);
    if (circle.empty()) return {};
    constexpr std::size_t kShown = 6;
    const auto name = [&](graph::Node node) {
        for (const graph::Column& column : graph.node_columns)
            if (column.name == "name") return column.text(node);
        return fmt::format("@{}", graph.id(node));
    };
    std::string way;
    for (std::size_t i = 0; i < std::min(circle.size(), kShown); ++i) way += name(circle[i]) + " -> ";
    if (circle.size() > kShown) way += fmt::format("{} more -> ", circle.size() - kShown);
    return fail(fmt::format("acyclic = true, and these links lead in a circle: {}{}", way, name(circle[0])),
                "take one of them out, or take acyclic out");
}

// Each node has a place.
void keep(World& world, graph::Graph graph) {
    if (graph.places.empty()) graph.places = graph::by_distances(graph);
    world.graph = std::make_shared<const graph::Graph>(std::move(graph));
}

}  // namespace

void refuse_graph_keys(TomlReader& reader, const Section& top) {
    for (const std::string_view key : kGraphKeys)
        // [links] range goes with bodies too.
        if (top.has(key) && !(key == "links" && links_by_range(top)))
            return reader.wrong(top.find(key)->source(), fmt::format("{} belongs to a graph, and this world has cells", key),
                                "write lattice = \"graph\", or take it out");
}

bool refuse_cells(TomlReader& reader, const Section& top) {
    for (const auto& [key, cure] : kNotInGraphs)
        if (top.has(key)) return reader.wrong(top.find(key)->source(), fmt::format("a graph has no {}", key), std::string(cure)), false;
    return true;
}

void read_graph_world(TomlReader& reader, const Section& top, World& world) {
    if (links_by_range(top)) return read_point_world(reader, top, world);
    const bool made = top.has("graph"), listed = top.has("links");
    if (made == listed)
        return reader.wrong(made ? top.find("links")->source() : top.find("lattice")->source(),
                            made ? "this world has both graph and links" : "this world has neither graph nor links",
                            "write graph = \"ring(100)\" or links = \"edges.csv\"");
    if (!refuse_cells(reader, top)) return;
    for (const std::string_view key : {"nodes", "directed", "acyclic"})
        if (made && top.has(key))
            return reader.wrong(top.find(key)->source(), fmt::format("{} goes with links, and this graph is generated", key),
                                "take it out");
    std::optional<bool> directed;
    if (top.has("directed")) top.read("directed", directed.emplace(false));
    if (made) top.read("graph", world.generator);
    if (reader.error()) return;
    const MemoryLimit room = memory_limit(world.limits.memory_bytes);
    Result<graph::Graph> graph = made ? graph::generate(world.generator, world.seed, room) : read_files(reader, top, directed, room);
    if (!graph) {
        // Mistakes in files have a place of their own.
        if (listed && graph.error().problem.find(": ") != std::string::npos) return reader.wrong(graph.error());
        const std::string place = reader.place(top.find(listed ? "links" : "graph")->source());
        return reader.wrong(Error{fmt::format("{}: {}", place, graph.error().problem), graph.error().suggestion, graph.error().code});
    }
    if (bool acyclic = false; top.has("acyclic")) {
        top.read("acyclic", acyclic);
        const Result<void> fine = acyclic ? check_acyclic(*graph) : Result<void>{};
        if (!fine) return reader.wrong(top.find("acyclic")->source(), fine.error().problem, fine.error().suggestion);
    }
    world.warnings = graph->warnings;
    keep(world, std::move(*graph));
}

Result<void> set_seed(World& world, std::uint64_t seed) {
    if (std::exchange(world.seed, seed) == seed || world.generator.empty()) return {};
    const MemoryLimit room = memory_limit(world.limits.memory_bytes);
    Result<graph::Graph> graph = graph::generate(world.generator, seed, room);
    if (!graph) return tl::unexpected<Error>(graph.error());
    if (world.links)
        if (auto linked = graph::link_within(*graph, world.links->range, world.generator, room, sight_in(*graph, *world.links)); !linked)
            return tl::unexpected<Error>(linked.error());
    keep(world, std::move(*graph));
    return {};
}

}  // namespace meld::world
