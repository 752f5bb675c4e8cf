#include "runtime/world/file/point_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <utility>

#include "runtime/world/description/obstacles.h"
#include "runtime/world/description/point_sight.h"
#include "runtime/world/file/graph_section.h"
#include "runtime/world/file/obstacle_section.h"
#include "runtime/world/graph/files.h"
#include "runtime/world/graph/generate.h"
#include "runtime/world/graph/range.h"

namespace meld::world {
namespace {

// nodes = "points.csv".
Result<graph::Graph> read_point_file(TomlReader& reader, const Section& top, const MemoryLimit& room) {
    std::string nodes;
    top.read("nodes", nodes);
    graph::FileText file{reader.beside(nodes), {}};
    const Result<std::string> text = reader.read_file(file.path, kMaxGraph_bytes);
    if (!text) return tl::unexpected<Error>(text.error());
    file.text = *text;
    return graph::read_points(file, room);
}

// Points, and links between those that are in range.
Result<graph::Graph> make_points(TomlReader& reader, const Section& top, const World& world, const MemoryLimit& room) {
    const bool made = top.has("graph");
    if (made && !graph::makes_points(world.generator))
        return fail(fmt::format("{} has links of its own, and [links] range makes them of the places of nodes", world.generator),
                    "write graph = \"disc(100, 20)\", scatter(100, 40, 30) or ball(100, 20), or take [links] out");
    Result<graph::Graph> graph = made ? graph::generate(world.generator, world.seed, room) : read_point_file(reader, top, room);
    if (!graph) return graph;
    const std::string what = made ? world.generator : "the list of nodes";
    if (auto linked = graph::link_within(*graph, world.links->range, what, room, sight_in(*graph, *world.links)); !linked)
        return tl::unexpected<Error>(linked.error());
    return graph;
}

}  // namespace

bool links_by_range(const Section& top) { return top.has("links") && top.find("links")->is_table(); }

void read_range(TomlReader& reader, const toml::table& table, World& world) {
    const Section section(reader, table, "[links]", {"range", "noise", "sight", "thickness", "obstacle"});
    RangeOptions links;
    if (!section.has("range"))
        return reader.wrong(table.source(), "[links] does not say how far a link reaches", "add range = 3.0, in catom diameters");
    section.read_positive("range", links.range);
    if (const toml::node* noise = section.find("noise")) {
        if (!noise->is_table()) return section.wrong("noise", "noise " + type_mismatch(*noise, "a table [links.noise]"));
        const Section sensed(reader, *noise->as_table(), "[links.noise]", {"distance", "bearing"});
        sensed.read_number("distance", links.distance_noise, 0);
        double degrees = 0;
        sensed.read_number("bearing", degrees, 0, 360);
        links.bearing_noise_rad = degrees * std::numbers::pi / 180;
    }
    section.read("sight", links.sight);
    section.read_number("thickness", links.thickness, 0);
    read_obstacles(reader, table, "links", Touched::No, {}, links.obstacles);
    for (const char* key : {"thickness", "obstacle"})
        if (section.has(key) && !links.sight)
            section.wrong(key, fmt::format("[links] {} says what is in the way of sight, and sight does not matter here", key),
                          "write sight = true too");
    // Shapes that were refused are no obstacles.
    if (reader.error()) return;
    if (const auto fine = obstacles_of_points(links); !fine) return reader.wrong(fine.error());
    world.links = links;
}

void read_point_world(TomlReader& reader, const Section& top, World& world) {
    const bool made = top.has("graph");
    if (made == top.has("nodes"))
        return reader.wrong(
            top.find(made ? "nodes" : "links")->source(),
            made ? "this world has both graph and nodes" : "[links] range says which nodes are linked, but not which there are",
            "write graph = \"disc(100, 20)\" or nodes = \"points.csv\"");
    if (!refuse_cells(reader, top)) return;
    for (const std::string_view key : {"directed", "acyclic"})
        if (top.has(key))
            return reader.wrong(top.find(key)->source(), fmt::format("{} goes with a list of links, and [links] range has none", key),
                                "take it out");
    read_range(reader, *top.find("links")->as_table(), world);
    if (made) top.read("graph", world.generator);
    if (reader.error()) return;
    Result<graph::Graph> graph = make_points(reader, top, world, memory_limit(world.limits.memory_bytes));
    if (!graph) {
        // Mistakes in files have a place of their own.
        if (!made && graph.error().problem.find(": ") != std::string::npos) return reader.wrong(graph.error());
        const std::string place = reader.place(top.find(made ? "graph" : "nodes")->source());
        return reader.wrong(Error{fmt::format("{}: {}", place, graph.error().problem), graph.error().suggestion, graph.error().code});
    }
    // Pictures show the points as they lie.
    if (std::ranges::any_of(graph->places, [](const graph::Point& at) { return at[2] != 0; })) world.lattice = LatticeKind::Cubic;
    world.graph = std::make_shared<const graph::Graph>(std::move(*graph));
}

void read_points(TomlReader& reader, const toml::table& table, MotionOptions& motion) {
    const Section section(reader, table, "[motion]", {"kind", "speed"});
    motion.kind = "points";
    section.read_positive("speed", motion.speed);
}

void check_moving(TomlReader& reader, const Section& top, const World& world) {
    if (world.links && !world.is_graph() && !world.is_free())
        return reader.wrong(top.find("links")->source(), "catoms on a lattice are linked where they touch, and not within a range",
                            "write lattice = \"graph\" for points, or [motion] kind = \"bodies\"");
    if (world.links && world.is_free())
        for (const char* key : {"thickness", "obstacle"})
            if (const toml::node* node = top.find("links")->as_table()->get(key))
                return reader.wrong(node->source(), fmt::format("[links] {} is of points, and this world has bodies", key),
                                    "take it out: bodies are as thick as they are, and obstacles are [[motion.obstacle]]");
    const bool points = world.motion.kind == "points";
    if (points ? world.is_graph() && world.links : !world.is_graph() || world.motion.kind == "none") return;
    const toml::source_region& motion = top.find("motion")->source();
    if (!world.is_graph())
        return reader.wrong(motion, "points are nodes of a graph, and this world has cells",
                            "write lattice = \"graph\", or kind = \"lattice\"");
    if (points)
        return reader.wrong(motion, "nodes that move are linked while they are near each other, and this graph has links of its own",
                            "write [links] range = 3.0 instead of them, or take [motion] out");
    reader.wrong(motion, "nodes of a graph do not move", world.links ? "write kind = \"points\"" : "take [motion] out");
}

}  // namespace meld::world
