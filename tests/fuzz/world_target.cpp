// Fuzz target: whatever the text of a world and of the files that it names, it is read or refused. A world that is read is read the same
// way again, has no more catoms than were computed for it, and its regions, events and target have answers.
//
// A line "=== name" in the input begins the file of that name; what stands before the first is the world.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/assert.h"
#include "runtime/world/description/measure.h"
#include "runtime/world/description/populate.h"
#include "runtime/world/ensemble/target.h"
#include "runtime/world/file/world_file.h"
#include "runtime/world/graph/divide.h"
#include "runtime/world/shapes/nearest_cell.h"

namespace {

using namespace meld;
using namespace meld::world;

constexpr std::string_view kFile = "\n=== ";
// Larger worlds are read, but not made: an input should take milliseconds.
constexpr std::uint64_t kMostCatoms = 2'000;
constexpr std::string_view kLittleMemory = "\n[limits]\nmemory = \"4MiB\"\n";

struct Input {
    std::string text;  // With little memory for a graph, unless it speaks of limits itself.
    WorldFiles files;
};

Input split(std::string_view all) {
    Input out;
    std::size_t end = std::min(all.find(kFile), all.size());
    out.text = all.substr(0, end);
    while (end < all.size()) {
        all.remove_prefix(end + kFile.size());
        end = std::min(all.find(kFile), all.size());
        const std::string_view file = all.substr(0, end);
        const std::size_t name = std::min(file.find('\n'), file.size());
        out.files[std::string(file.substr(0, name))] = file.substr(std::min(name + 1, file.size()));
    }
    if (out.text.find("limits") == std::string::npos) out.text += kLittleMemory;
    return out;
}

// Whether it may ask for a graph that takes long to make.
bool may_be_long(const std::string& text) { return text.find("graph") != std::string::npos && !text.ends_with(kLittleMemory); }

std::vector<Region> regions_of(const World& world) {
    std::vector<Region> out;
    for (const GivenFact& fact : world.facts) out.push_back(fact.where);
    for (const ProgramRegion& region : world.program_regions) out.push_back(region.where);
    for (const Faults& faults : world.faults) out.push_back(faults.where);
    for (const NetworkOptions::Part& part : world.network.parts) out.push_back(part.where);
    for (const Event& event : world.events) {
        for (const auto* all : {&event.give, &event.take})
            for (const GivenFact& fact : *all) out.push_back(fact.where);
        for (const auto* all : {&event.kill, &event.hang, &event.restart})
            for (const CatomChoice& choice : *all) out.push_back(choice.where);
        for (const auto* all : {&event.cut, &event.heal, &event.join})
            for (const LinkChoice& choice : *all) {
                out.push_back(choice.where);
                if (choice.other) out.push_back(*choice.other);
            }
    }
    return out;
}

void ask_events(const World& world) {
    for (const Event& event : world.events) {
        MELD_CHECK(event.tick >= 1 && event.times >= 1, "an event in tick {}, {} times", event.tick, event.times);
        for (const std::int64_t tick : {std::int64_t{1}, event.tick, event.last()}) {
            const std::int64_t latest = event.latest(tick);
            MELD_CHECK(latest == 0 || event.happens_in(latest), "tick {}", latest);
        }
    }
    static_cast<void>(world.expects_after(1));
}

void make_cells(const World& world) {
    const Result<WorldSize> size = measure(world);
    MELD_CHECK(size.has_value(), "a world was read that has no size");
    if (size->cells_upper_bound > kMostCatoms) return;
    const Lattice lattice(world.lattice);
    const std::vector<Region> regions = regions_of(world);
    std::uint64_t catoms = 0;
    std::vector<std::uint32_t> cells;
    for (const auto& [brick, count] : count_bricks(world, lattice, 0, 1)) {
        cells_of_brick(world, lattice, brick, cells);
        MELD_CHECK(cells.size() == count, "{} of {} cells", cells.size(), count);
        for (const std::uint32_t number : cells) {
            const Cell cell = lattice.cell_in_brick(lattice.brick_at(brick), number);
            for (const Region& region : regions) static_cast<void>(region.contains(catoms, cell, lattice.position(cell)));
            ++catoms;
        }
    }
    MELD_CHECK(static_cast<double>(catoms) <= size->cells_upper_bound, "{} catoms, at most {}", catoms, size->cells_upper_bound);
    if (world.target) static_cast<void>(Target::make(world, lattice));
}

void ask_graph(const World& world) {
    const graph::Graph& graph = *world.graph;
    MELD_CHECK(graph.places.size() == graph.nodes() && graph.first.back() == graph.to.size(), "{} nodes", graph.nodes());
    const std::vector<Region> regions = regions_of(world);
    for (const graph::Column& column : graph.node_columns) MELD_CHECK(column.size() == graph.nodes(), "{}", column.name);
    for (graph::Node node = 0; node < graph.nodes(); ++node) {
        MELD_CHECK(graph.find(graph.id(node)) == node && graph.id(node) < graph.next_id(), "node {}", node);
        MELD_CHECK(std::isfinite(graph.places[node][0]) && std::isfinite(graph.places[node][1]), "node {}", node);
        const Vec3 at = {graph.places[node][0], graph.places[node][1], 0};
        for (const Region& region : regions) static_cast<void>(region.contains(graph.id(node), nearest_cell(at), at));
        for (const graph::Node other : graph.neighbours(node)) {
            const auto back = graph.neighbours(other);
            MELD_CHECK(other != node && std::binary_search(back.begin(), back.end(), node), "link of {} and {}", node, other);
        }
    }
    for (const std::int32_t part : graph::divide(graph, 3)) MELD_CHECK(part >= 0 && part < 3, "part {}", part);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const Input input = split({reinterpret_cast<const char*>(data), size});
    if (may_be_long(input.text)) return 0;
    const auto read = [&] { return parse_world(input.text, "w.toml", &input.files); };
    Result<World> world = read();
    if (!world) {
        MELD_CHECK(!world.error().problem.empty(), "an error without a problem");
        return 0;
    }
    const Result<World> again = read();
    MELD_CHECK(again && again->source_hash == world->source_hash && again->parts == world->parts, "read differently again");
    ask_events(*world);
    world->is_graph() ? ask_graph(*world) : make_cells(*world);
    static_cast<void>(set_seed(*world, world->seed + 1));
    return 0;
}
