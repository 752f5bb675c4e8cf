#include "runtime/partition/partition.h"

#include <algorithm>

#include "runtime/base/assert.h"

namespace meld::partition {

Partition::Partition(const std::vector<std::pair<BrickKey, std::uint32_t>>& counts, int processes) {
    MELD_EXPECT(processes > 0);
    MELD_EXPECT(std::is_sorted(counts.begin(), counts.end()), "bricks along the curve");
    std::uint64_t total = 0;
    for (const auto& [key, count] : counts) total += count;
    starts_.assign(1, 0);
    std::uint64_t before = 0;
    for (const auto& [key, count] : counts) {
        // A brick belongs to the process in whose share its middle catom falls.
        const auto share =
            static_cast<std::size_t>((before + count / 2) * static_cast<std::uint64_t>(processes) / std::max<std::uint64_t>(1, total));
        while (starts_.size() <= share && starts_.size() < static_cast<std::size_t>(processes)) starts_.push_back(key);
        before += count;
    }
    while (starts_.size() < static_cast<std::size_t>(processes)) starts_.push_back(~BrickKey{0});
    MELD_ENSURE(std::is_sorted(starts_.begin(), starts_.end()) && starts_.size() == static_cast<std::size_t>(processes));
}

int Partition::owner(BrickKey key) const {
    const auto after = std::upper_bound(starts_.begin() + 1, starts_.end(), key);
    return static_cast<int>(after - starts_.begin()) - 1;
}

Halo::Halo(const world::Ensemble& ensemble, const Partition& partition, int process, int reach)
    : ensemble_(ensemble), partition_(partition), process_(process), reach_(reach) {
    MELD_EXPECT(process >= 0 && process < partition.processes() && reach > 0, "process {} of {}, reach {}", process, partition.processes(),
                reach);
}

std::vector<Halo::Side> Halo::sides(Cell brick) const {
    std::vector<Side> out;
    const bool flat = lattice().flat();
    const auto& bits = lattice().brick_bits();
    const auto limit = [&](std::size_t axis) { return world::kCellLimit >> bits[axis]; };
    for (int dz = flat ? 0 : -1; dz <= (flat ? 0 : 1); ++dz)
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
                const Cell other = brick + Cell{dx, dy, dz};
                if (other.x < -limit(0) || other.x >= limit(0) || other.y < -limit(1) || other.y >= limit(1) || other.z < -limit(2) ||
                    other.z >= limit(2))
                    continue;
                const int owner = partition_.owner(lattice().brick_key(other));
                out.push_back({static_cast<std::int8_t>(dx), static_cast<std::int8_t>(dy), static_cast<std::int8_t>(dz), owner});
            }
    return out;
}

bool Halo::near(const Side& side, std::uint32_t cell) const {
    const auto& bits = lattice().brick_bits();
    MELD_EXPECT(cell < kBrickCells, "cell {} of a brick", cell);
    const auto reach = static_cast<std::uint32_t>(reach_);
    const auto close = [&](int step, std::size_t axis, std::uint32_t at) {
        const std::uint32_t size = 1u << bits[axis];
        return step == 0 || (step < 0 ? at < reach : at + reach >= size);
    };
    const std::uint32_t x = cell & ((1u << bits[0]) - 1), y = cell >> bits[0] & ((1u << bits[1]) - 1), z = cell >> (bits[0] + bits[1]);
    return close(side.dx, 0, x) && close(side.dy, 1, y) && close(side.dz, 2, z);
}

void Halo::prepare() {
    if (partition_.processes() == 1) return;
    for (std::size_t slot = border_.size(); slot <= ensemble_.brick_count(); ++slot) {
        std::vector<Side> all;
        if (slot > 0) all = sides(ensemble_.brick(static_cast<world::Slot>(slot)));
        const bool ours = std::all_of(all.begin(), all.end(), [&](const Side& side) { return side.process == process_; });
        border_.push_back(ours ? -1 : static_cast<std::int32_t>(sides_.size()));
        if (!ours) sides_.push_back(std::move(all));
    }
}

namespace {

std::vector<int> distinct(std::vector<int> processes) {
    std::sort(processes.begin(), processes.end());
    processes.erase(std::unique(processes.begin(), processes.end()), processes.end());
    return processes;
}

}  // namespace

std::vector<int> Halo::around(Cell cell) const {
    std::vector<int> processes;
    each_side(lattice().brick_of(cell), [&](const Side& side) {
        if (side.process != process_) processes.push_back(side.process);
    });
    return distinct(std::move(processes));
}

int Halo::owner(Cell cell) const {
    return partition_.processes() == 1 ? process_ : partition_.owner(ensemble_.key(cell) >> kBrickCellBits);
}

std::vector<int> Halo::listeners(Cell cell) const {
    std::vector<int> processes;
    const std::uint32_t number = lattice().number_in_brick(cell);
    each_side(lattice().brick_of(cell), [&](const Side& side) {
        if (near(side, number)) processes.push_back(side.process);
    });
    return distinct(std::move(processes));
}

}  // namespace meld::partition
