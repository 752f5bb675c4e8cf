#include "runtime/sim/balance.h"

#include <algorithm>
#include <utility>

#include "runtime/base/bytes.h"

namespace meld::sim {

void Balance::note(const Subdomain& subdomain) {
    const Geometry& geometry = subdomain.geometry();
    work_.resize(subdomain.ensemble.brick_count() + 1);
    subdomain.each_evaluated([&](u32 catom, u64) {
        ++work_[geometry.catom_site[catom] >> kBrickCellBits];
        ++mine_;
    });
}

std::vector<std::uint64_t> Balance::work_of_processes(const Subdomain& subdomain) {
    ByteWriter mine;
    mine.write(std::exchange(mine_, 0));
    const std::vector<std::byte> theirs = subdomain.comm.allgather(mine.view());
    std::vector<std::uint64_t> all;
    for (ByteReader in(theirs, "the work of all processes"); !in.done();) all.push_back(in.read<std::uint64_t>());
    return all;
}

std::vector<partition::BrickWork> Balance::work_of_bricks(const Subdomain& subdomain) const {
    const world::Ensemble& ensemble = subdomain.ensemble;
    const Geometry& geometry = subdomain.geometry();
    ByteWriter mine;
    for (world::Slot slot = 1; slot <= ensemble.brick_count(); ++slot) {
        std::uint64_t catoms = 0;
        for (std::uint32_t cell = 0; cell < kBrickCells; ++cell) {
            const std::int32_t at = geometry.cell_catom[(std::size_t{slot} << kBrickCellBits) + cell];
            catoms += at >= 0 && subdomain.owned(static_cast<Catom>(at));
        }
        if (catoms > 0) mine.write(partition::BrickWork{subdomain.lattice.brick_key(ensemble.brick(slot)), work_[slot], catoms});
    }
    std::vector<partition::BrickWork> all;
    for (const auto& bytes : subdomain.comm.allgather_any(mine.view()))
        for (ByteReader in(bytes, "the work of bricks"); !in.done();) all.push_back(in.read<partition::BrickWork>());
    std::ranges::sort(all, {}, &partition::BrickWork::key);
    return all;
}

std::optional<partition::Partition> Balance::after_tick(const Subdomain& subdomain) {
    note(subdomain);
    if (++ticks_ < window_) return std::nullopt;
    ticks_ = 0;
    rule_.end_window(work_of_processes(subdomain));
    std::optional<partition::Partition> next;
    if (rule_.looks()) next = rule_.divide(work_of_bricks(subdomain), *subdomain.partition, subdomain.tick());
    std::ranges::fill(work_, 0);
    return next;
}

}  // namespace meld::sim
