#include <algorithm>
#include <numeric>
#include <regex>
#include <set>

#include "runtime/driver/shrink/list_world.h"

namespace meld::driver {

namespace {

bool mentions(const std::string& region, const char* what) { return std::regex_search(region, std::regex(what)); }

constexpr const char* kNumbers = "\\bid\\b";
constexpr const char* kPlaces = "\\b(x|y|z|cell|inside)\\b";

void add_strings(const toml::node& node, std::set<std::string>& all) {
    if (node.is_string()) all.insert(**node.as_string());
    if (const toml::array* array = node.as_array())
        for (const toml::node& each : *array) add_strings(each, all);
    if (const toml::table* table = node.as_table())
        for (const auto& [key, value] : *table) add_strings(value, all);
}

// All regions of the world, and perhaps some other strings of its events.
std::set<std::string> regions_of(const SmallWorld& small) {
    std::set<std::string> all;
    const auto note = [&](const std::string& region) -> std::optional<std::string> {
        all.insert(region);
        return std::nullopt;
    };
    toml::table keys = small.keys;
    change_regions(keys, note);
    if (const toml::node* events = small.keys.get("event")) add_strings(*events, all);
    if (small.events)
        for (const Happening& each : *small.events) add_strings(each.item, all);
    return all;
}

}  // namespace

bool stays_still(const world::World& world, bool makes_nodes) {
    return world.motion.kind == "none" && world.components.empty() && !makes_nodes;
}

bool list_catoms(SmallWorld& small, const world::World& world, const StartCatoms& start) {
    if (world.is_graph()) {
        const graph::Graph& graph = *world.graph;
        if (graph.nodes() + graph.links() > kMostListed) return false;
        GraphList list{.whole = world.graph, .nodes = std::vector<graph::Node>(graph.nodes()), .links = graph::entries(graph)};
        // Nodes whose numbers are near each other mostly are so too.
        std::iota(list.nodes.begin(), list.nodes.end(), graph::Node{0});
        const std::set<std::string> regions = regions_of(small);
        list.as_files = !graph.columns.empty() || !graph.node_columns.empty() ||
                        std::ranges::any_of(regions, [](const std::string& region) { return mentions(region, kPlaces); });
        small.graph = std::move(list);
        for (const char* key : {"graph", "links", "nodes", "directed"}) small.keys.erase(key);
        return true;
    }
    // The parts of a robot stay together.
    if (start.all().size() + world.placed.size() > kMostListed || world.robots) return false;
    std::vector<world::Cell> cells;
    if (world.is_free()) {
        world::World without = world;
        without.motion.kind = "none";
        const StartCatoms placed = StartCatoms::of(without);
        for (const StartCatoms::One& one : placed.all()) cells.push_back(one.cell);
    }
    for (const StartCatoms::One& one : start.all()) cells.push_back(one.cell);
    for (const std::string& region : regions_of(small)) {
        if (world.is_free() || !mentions(region, kNumbers)) continue;
        const Result<world::Region> parsed = world::Region::parse(region);
        if (!parsed) continue;
        std::vector<world::Cell> meant;
        for (const std::size_t catom : start.in(*parsed)) meant.push_back(start.all()[catom].cell);
        small.cells_of_regions[region] = std::move(meant);
    }
    small.cells = std::move(cells);
    small.placed = world.placed;
    for (const char* key : {"body", "without"}) small.keys.erase(key);
    return true;
}

}  // namespace meld::driver
