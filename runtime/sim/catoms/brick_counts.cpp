#include "runtime/sim/catoms/brick_counts.h"

#include <algorithm>

#include "runtime/base/bytes.h"
#include "runtime/world/description/measure.h"
#include "runtime/world/description/populate.h"

namespace meld::sim {

namespace {

// Counting takes less than a tenth of the time that the set-up takes, but larger worlds may be typing errors.
constexpr double kMostCounted = 2e8;

}  // namespace

BrickCounts count_together(const world::World& world, const world::Lattice& lattice, comm::Communicator& comm, Workers& workers) {
    const BrickCounts mine = world::count_bricks(world, lattice, comm.process(), comm.processes(), &workers);
    if (comm.processes() == 1) return mine;
    ByteWriter bytes;
    for (const auto& [key, count] : mine) {
        bytes.write(key);
        bytes.write(count);
    }
    BrickCounts all;
    for (const auto& share : comm.allgather_any(bytes.view())) {
        ByteReader in(share, "the counts of bricks");
        while (!in.done()) {
            const auto key = in.read<world::BrickKey>();
            all.emplace_back(key, in.read<std::uint32_t>());
        }
    }
    std::sort(all.begin(), all.end());
    return all;
}

Result<std::optional<BrickCounts>> count_beforehand(const world::World& world, comm::Communicator& comm, int threads) {
    const Result<world::WorldSize> size = world::measure(world);
    if (!size) return tl::unexpected<Error>(size.error());
    if (world.is_graph() || size->cells_estimate > kMostCounted) return std::nullopt;
    Workers workers(threads);
    return count_together(world, world::Lattice(world.lattice), comm, workers);
}

}  // namespace meld::sim
