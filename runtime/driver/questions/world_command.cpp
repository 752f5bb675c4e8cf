#include "runtime/driver/questions/world_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/base/files/input_file.h"
#include "runtime/base/files/output_file.h"
#include "runtime/base/files/output_paths.h"
#include "runtime/base/files/standard_streams.h"
#include "runtime/base/terminal/log.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/base/units.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/driver/pictures/picture_options.h"
#include "runtime/driver/pictures/shot.h"
#include "runtime/driver/setup/extension_file.h"
#include "runtime/driver/setup/memory_check.h"
#include "runtime/driver/setup/print_error.h"
#include "runtime/results/record/drawing.h"
#include "runtime/sim/choices.h"
#include "runtime/sim/simulation.h"
#include "runtime/world/description/measure.h"
#include "runtime/world/description/populate.h"
#include "runtime/world/ensemble/target.h"
#include "runtime/world/file/world_file.h"
#include "runtime/world/graph/write.h"
#include "runtime/world/model/visiblesim.h"
#include "runtime/world/shapes/nearest_cell.h"

namespace meld::driver {

namespace {

// A module of no program: it has neither predicates nor rules.
constexpr ModuleInfo kNoProgram = [] {
    ModuleInfo none{};
    none.abi_version = kAbiVersion;
    return none;
}();

std::string graph_text(const world::World& world) {
    const graph::Graph& graph = *world.graph;
    const graph::Degrees degrees = graph::degrees(graph);
    const std::uint64_t components = graph::components(graph);
    const auto counted = [](std::uint64_t n, const char* one) { return fmt::format("{} {}{}", n, one, n == 1 ? "" : "s"); };
    const std::string range =
        world.links ? fmt::format("; linked up to the distance {}{}{}", world.links->range,
                                  world.links->sight ? ", in sight of each other" : "", world.has_moving_nodes() ? ", and moving" : "")
                    : "";
    return fmt::format("{}: {}graph, {}, {}, degrees {} to {}, {:.2f} on average, {}{}\n", visible(world.path),
                       graph.directed ? "directed " : "", counted(graph.nodes(), "node"), counted(graph.links(), "link"), degrees.least,
                       degrees.most, degrees.mean, counted(components, "component"), range);
}

// How many catoms there are, and the least box of cells that holds them all.
class Extent {
  public:
    Extent(const world::World& world, const world::Lattice& lattice) : catoms(world.placed.size()) {
        for (const world::PlacedCatom& placed : world.placed) add(world::nearest_cell(placed.position));
        std::vector<std::uint32_t> numbers;
        for (const auto& [key, count] : world::count_bricks(world, lattice, 0, 1)) {
            catoms += count;
            const world::Cell brick = lattice.brick_at(key);
            // Few bricks are at the border of what has been seen; only their cells are looked at one by one.
            if (holds(lattice.brick_origin(brick)) && holds(lattice.cell_in_brick(brick, kBrickCells - 1))) continue;
            world::cells_of_brick(world, lattice, key, numbers);
            for (const std::uint32_t number : numbers) add(lattice.cell_in_brick(brick, number));
        }
    }

    std::uint64_t catoms = 0;
    world::Cell first, last;

  private:
    static constexpr std::int32_t world::Cell::* kSides[] = {&world::Cell::x, &world::Cell::y, &world::Cell::z};

    bool holds(world::Cell cell) const {
        return any_ && std::ranges::all_of(kSides, [&](auto side) { return first.*side <= cell.*side && cell.*side <= last.*side; });
    }
    void add(world::Cell cell) {
        for (const auto side : kSides) {
            first.*side = any_ ? std::min(first.*side, cell.*side) : cell.*side;
            last.*side = any_ ? std::max(last.*side, cell.*side) : cell.*side;
        }
        any_ = true;
    }

    bool any_ = false;
};

std::string cells_text(world::Cell first, world::Cell last) {
    return fmt::format("({}, {}, {}) to ({}, {}, {})", first.x, first.y, first.z, last.x, last.y, last.z);
}

std::string size_text(const world::World& world, const world::WorldSize& size) {
    if (world.is_graph()) return graph_text(world);
    const world::Lattice lattice(world.lattice);
    const std::string what = fmt::format("{}: {} lattice", visible(world.path), lattice.name());
    // Counting is exact and fast up to some hundred million.
    if (size.cells_estimate >= 2e8)
        return fmt::format("{}, about {} catoms, somewhere within cells {}\n", what, format_count(size.cells_estimate),
                           cells_text(size.first, size.last));
    const Extent extent(world, lattice);
    return fmt::format("{}, {} catom{}, within cells {}\n", what, extent.catoms, extent.catoms == 1 ? "" : "s",
                       cells_text(extent.first, extent.last));
}

// How many robots there are of which assembly. Empty: the world describes none.
std::string robots_text(const world::World& world) {
    if (!world.robots) return "";
    std::vector<std::uint64_t> robots(world.robots->assemblies().size());
    for (const world::RobotGroup& group : world.robots->groups()) robots[group.assembly] += group.robots;
    std::vector<std::string> parts;
    for (std::size_t i = 0; i < robots.size(); ++i) {
        const world::Assembly& assembly = world.robots->assemblies()[i];
        const std::size_t bodies = assembly.parts.size();
        parts.push_back(fmt::format("{} {} of {} bod{}", robots[i], assembly.name, bodies, bodies == 1 ? "y" : "ies"));
    }
    return fmt::format("robots: {}\n", fmt::join(parts, ", "));
}

// What links are like, if not as in the ideal network. Empty: they are.
std::string network_text(const world::World& world) {
    const world::NetworkOptions& network = world.network;
    std::vector<std::string> parts;
    if (world.clock.gives_turns())
        parts.push_back(
            fmt::format("what changes at a catom has come to its neighbours after at most {} tick{}, and they act in their turn",
                        world.latency(), world.latency() == 1 ? "" : "s"));
    else if (world.apart())
        parts.push_back(fmt::format("what changes at a catom has been acted on by its neighbours after at most {} ticks", world.latency()));
    if (!network.singles.empty()) parts.push_back(fmt::format("single links with terms of their own: {}", network.singles.size()));
    if (network.reach == world::Reach::Any) parts.push_back("linear facts reach any node in one hop");
    if (network.detect > 0)
        parts.push_back(fmt::format("an end is sensed after {} tick{}", network.detect, network.detect == 1 ? "" : "s"));
    return parts.empty() ? "" : fmt::format("network: {}\n", fmt::join(parts, "; "));
}

// Which obstacles move. Empty: none of them.
std::string obstacles_text(const world::World& world) {
    const std::vector<world::ObstacleOptions>& all = world.physics.obstacles;
    const auto moving = std::ranges::count_if(all, [](const world::ObstacleOptions& o) { return o.motion.moves(); });
    if (!world.is_free() || moving == 0) return "";
    return fmt::format("obstacles: {}, {} of which move{}\n", all.size(), moving, moving == 1 ? "s" : "");
}

std::string memory_text(const MemoryNeed& need, double seconds) {
    const auto bytes = [](double amount) { return format_bytes(static_cast<std::uint64_t>(amount)); };
    return fmt::format("memory: {} for the catoms of one process, {:.0f} bytes each, before the facts of a program; placed in {:.2f} s\n",
                       bytes(need.made().least), need.made().least / std::max(1.0, need.own_catoms), seconds);
}

// Checks whether a run could start: places the catoms and hands them to the motion. Checks that need a program are left out: facts,
// settings and components.
Result<void> check_start(world::World world, const world::Target& target, const sim::Registry& registry, const PictureOptions& picture,
                         std::FILE* talk) {
    if (!picture.file.empty())
        if (const auto fine = last_tick_of(picture); !fine) return tl::unexpected<Error>(fine.error());
    const auto begun = std::chrono::steady_clock::now();
    const auto alone = comm::make_single();
    auto counts = sim::count_beforehand(world, *alone, 1);
    if (!counts) return tl::unexpected<Error>(counts.error());
    const MemoryNeed need = memory_need(world, kNoProgram, {}, 1, *counts);
    if (const auto fits = check_memory(world, need, 1); !fits) return fits;
    world.components.clear();
    world.facts.clear();
    // Links that events join are there for the network and for faults, if their nodes are those of the graph.
    for (world::Event& event : world.events) {
        event = {.tick = event.tick, .every = event.every, .times = event.times, .join = std::move(event.join)};
        std::erase_if(event.join, [&](const world::LinkChoice& one) {
            return !world.graph->find(one.pair->first) || !world.graph->find(one.pair->second);
        });
    }
    world.set.clear();
    ModuleInfo no_program = kNoProgram;
    no_program.by_links = world.by_links;
    sim::Simulation simulation(no_program, world, target, *alone, 1);
    auto drawn = std::make_unique<record::Drawing>();
    record::Drawing& drawing = *drawn;
    simulation.add(std::move(drawn), "drawing");
    if (auto started = simulation.start(registry, std::move(*counts)); !started) return started;
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begun;
    if (auto printed = print(talk, memory_text(need, taken.count())); !printed) return printed;
    return picture.file.empty() ? Result<void>() : shoot_start(picture, world, simulation.subdomain(), drawing);
}

// One of the files of a graph, which a world can name.
Result<void> write_graph(const world::World& world, const std::string& path, const char* option,
                         Result<void> (*write)(const graph::Graph&, const graph::Put&), std::FILE* talk) {
    if (path.empty()) return {};
    if (!world.is_graph())
        return fail(fmt::format("{}: {} has a lattice, whose catoms are linked where they touch", option, world.path),
                    "Leave it out, or choose lattice = \"graph\"");
    Result<OutputFile> file = OutputFile::open(path, Appears::Whole);
    if (!file) return tl::unexpected<Error>(file.error());
    std::uint64_t lines = 0;
    if (auto done = write(*world.graph, [&](std::string_view line) { file->write(line), ++lines; }); !done) return done;
    if (auto written = file->commit(); !written) return written;
    return path == "-" ? Result<void>{} : print(talk, fmt::format("{}: {} {}\n", visible(path), lines - 1, option + 2));
}

Result<void> check_world(const WorldOptions& options) {
    if (options.file.empty()) return fail("no world is named", "Write meldsim world FILE.toml");
    const NamedPath paths[] = {{"the world", options.file},
                               {"--shot", options.picture.file, NamedPath::Written},
                               {"--links", options.links, NamedPath::Written},
                               {"--nodes", options.nodes, NamedPath::Written}};
    if (const auto distinct = check_distinct(paths); !distinct) return distinct;
    const Result<world::World> world = world::read_world(options.file);
    if (!world) return tl::unexpected<Error>(world.error());
    const Result<world::WorldSize> size = world::measure(*world);
    if (!size) return tl::unexpected<Error>(size.error());
    const Result<world::Target> target = world::Target::make(*world, world::Lattice(world->lattice));
    if (!target) return tl::unexpected<Error>(target.error());
    sim::Registry registry = sim::Registry::standard();
    if (const auto added = add_extensions(options.extensions, registry); !added) return added;
    if (const auto known = sim::check_choices(registry, *world); !known) return known;
    std::string text = size_text(*world, *size);
    if (world->target)
        text += fmt::format("target: {}{}\n", target->text(), target->cells() ? fmt::format(", {} cells of it", *target->cells()) : "");
    text += robots_text(*world);
    text += network_text(*world);
    text += obstacles_text(*world);
    {
        const log::FewWarnings few;
        for (const std::string& each : world->warnings) log::warning("{}", each);
    }
    std::FILE* const talk = options.picture.file == "-" || options.links == "-" || options.nodes == "-" ? stderr : stdout;
    if (const auto printed = print(talk, text); !printed) return printed;
    if (auto fine = check_start(*world, *target, registry, options.picture, talk); !fine) return fine;
    if (auto written = write_graph(*world, options.links, "--links", graph::write_links, talk); !written) return written;
    return write_graph(*world, options.nodes, "--nodes", graph::write_nodes, talk);
}

constexpr std::uint64_t kMaxImport_bytes = std::uint64_t{1} << 30;

Result<void> import_world(const WorldOptions& options) {
    const std::vector<std::string_view> lattices = world::Lattice::kind_names();
    if (!world::Lattice::kind_named(options.lattice))
        return fail(options.lattice.empty() ? "--import: a configuration of VisibleSim does not name its lattice"
                                            : fmt::format("--lattice: there is no lattice '{}'", options.lattice),
                    fmt::format("Write --lattice with one of {}", fmt::join(lattices, ", ")));
    if (options.output.empty()) return fail("--import: the world has no name", "Write -o world.toml");
    const NamedPath paths[] = {{"--import", options.import}, {"--output", options.output, NamedPath::Written}};
    if (const auto distinct = check_distinct(paths); !distinct) return distinct;
    const Result<std::string> xml = read_input(options.import, kMaxImport_bytes, InputKind::FileOrPipe);
    if (!xml) return tl::unexpected<Error>(xml.error());
    const Result<model::ImportedWorld> made = model::import_visiblesim(*xml, options.import, options.lattice);
    if (!made) return tl::unexpected<Error>(made.error());
    // Places in what was not written yet say nothing to anybody.
    if (const auto fine = world::parse_world(made->text, fmt::format("the world made of {}", options.import)); !fine)
        return fail(fmt::format("{} makes no world: {}", options.import, fine.error().problem), fine.error().suggestion);
    Result<OutputFile> file = OutputFile::open(options.output, Appears::Whole);
    if (!file) return tl::unexpected<Error>(file.error());
    file->write(made->text);
    if (auto written = file->commit(); !written) return written;
    const std::string left = made->left_out.empty() ? "" : fmt::format("; left out: {}", fmt::join(made->left_out, ", "));
    const std::string target = made->target_cells == 0 ? "" : fmt::format(", and a target of {} cells", made->target_cells);
    return print(options.output == "-" ? stderr : stdout,
                 fmt::format("{}: {} catom{} of {}{}{}\n", visible(options.output), made->cells, made->cells == 1 ? "" : "s",
                             visible(options.import), target, visible(left)));
}

}  // namespace

int world_command(const WorldOptions& options) {
    const Result<void> done = options.import.empty() ? check_world(options) : import_world(options);
    return done ? 0 : print_error(done.error());
}

}  // namespace meld::driver
