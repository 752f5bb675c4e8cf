#include "runtime/driver/world_command.h"

#include <fmt/format.h>

#include "runtime/base/error.h"
#include "runtime/base/units.h"
#include "runtime/world/populate.h"
#include "runtime/world/target.h"

namespace meld::driver {

int world_command(const std::string& path) {
    const auto tell = [](const Error& error) {
        fmt::print(stderr, "meldsim: {}\n", error.message());
        return static_cast<int>(error.code);
    };
    const Result<world::World> world = world::read_world(path);
    if (!world) return tell(world.error());
    const Result<world::WorldSize> size = world::measure(*world);
    if (!size) return tell(size.error());
    const world::Lattice lattice(world->lattice);
    fmt::print("{}: {} lattice, ", path, lattice.name());
    // Counting is exact and quick up to some hundred million.
    if (size->cells_estimate < 2e8)
        fmt::print("{} catoms", world::count_catoms(*world, lattice));
    else
        fmt::print("about {} catoms", format_count(size->cells_estimate));
    fmt::print(", within cells ({}, {}, {}) to ({}, {}, {})\n", size->first.x, size->first.y, size->first.z, size->last.x, size->last.y,
               size->last.z);
    if (!world->target) return 0;
    const Result<world::Target> target = world::Target::make(*world, lattice);
    if (!target) return tell(target.error());
    fmt::print("target: {}{}\n", target->text(), target->cells() ? fmt::format(", {} cells of it", *target->cells()) : "");
    return 0;
}

}  // namespace meld::driver
