#include "runtime/driver/world_command.h"

#include <fmt/format.h>

#include "runtime/base/error.h"
#include "runtime/base/standard_streams.h"
#include "runtime/base/units.h"
#include "runtime/base/visible.h"
#include "runtime/comm/communicator.h"
#include "runtime/driver/extension_file.h"
#include "runtime/driver/memory_check.h"
#include "runtime/sim/choices.h"
#include "runtime/sim/simulation.h"
#include "runtime/world/populate.h"
#include "runtime/world/target.h"

namespace meld::driver {

namespace {

// A module of no program: it has neither predicates nor rules.
constexpr ModuleInfo kNoProgram = [] {
    ModuleInfo none{};
    none.abi_version = kAbiVersion;
    return none;
}();

std::string size_text(const world::World& world, const world::WorldSize& size) {
    const world::Lattice lattice(world.lattice);
    // Counting is exact and fast up to some hundred million.
    const std::string count = size.cells_estimate < 2e8 ? fmt::format("{} catoms", world::count_catoms(world, lattice))
                                                        : fmt::format("about {} catoms", format_count(size.cells_estimate));
    return fmt::format("{}: {} lattice, {}, within cells ({}, {}, {}) to ({}, {}, {})\n", visible(world.path), lattice.name(), count,
                       size.first.x, size.first.y, size.first.z, size.last.x, size.last.y, size.last.z);
}

// Checks whether a run could start: places the catoms and hands them to the motion. Checks that need a program are left out: facts,
// settings and components.
Result<void> check_start(world::World world, const world::Target& target, const sim::Registry& registry) {
    const auto alone = comm::make_single();
    auto counts = sim::count_beforehand(world, *alone);
    if (!counts) return tl::unexpected<Error>(counts.error());
    if (const auto fits = check_memory(world, memory_need(world, kNoProgram, {}, 1, *counts), 1); !fits) return fits;
    world.components.clear();
    world.facts.clear();
    world.events.clear();
    world.set.clear();
    sim::Simulation simulation(kNoProgram, world, target, *alone, 1);
    return simulation.start(registry, std::move(*counts));
}

Result<void> check_world(const std::string& path, const std::vector<std::string>& extensions) {
    const Result<world::World> world = world::read_world(path);
    if (!world) return tl::unexpected<Error>(world.error());
    const Result<world::WorldSize> size = world::measure(*world);
    if (!size) return tl::unexpected<Error>(size.error());
    const Result<world::Target> target = world::Target::make(*world, world::Lattice(world->lattice));
    if (!target) return tl::unexpected<Error>(target.error());
    sim::Registry registry = sim::Registry::standard();
    if (const auto added = add_extensions(extensions, registry); !added) return added;
    if (const auto known = sim::check_choices(registry, *world); !known) return known;
    std::string text = size_text(*world, *size);
    if (world->target)
        text += fmt::format("target: {}{}\n", target->text(), target->cells() ? fmt::format(", {} cells of it", *target->cells()) : "");
    if (const auto printed = print(stdout, text); !printed) return printed;
    return check_start(*world, *target, registry);
}

}  // namespace

int world_command(const std::string& path, const std::vector<std::string>& extensions) {
    const Result<void> done = check_world(path, extensions);
    if (done) return 0;
    static_cast<void>(print(stderr, fmt::format("meldsim: {}\n", visible(done.error().message()))));
    return static_cast<int>(done.error().code);
}

}  // namespace meld::driver
