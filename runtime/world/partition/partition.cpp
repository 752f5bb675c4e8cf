#include "runtime/world/partition/partition.h"

#include <algorithm>
#include <array>
#include <bit>

#include "runtime/base/assert.h"
#include "runtime/world/lattice/hilbert.h"

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

namespace {

// Looks for the bricks of a border in cubes of the curve, halved until they are bricks.
class BorderWalk {
  public:
    BorderWalk(const Partition& partition, const world::Lattice& lattice, std::span<const std::pair<BrickKey, std::uint32_t>> bricks,
               std::optional<int> of, const std::function<void(std::size_t)>& visit)
        : partition_(partition), lattice_(lattice), bricks_(bricks), of_(of), visit_(visit) {}

    // The bricks of the list from `begin` to `end` are those in one cube with sides of 2^level bricks. Its eight parts have 64 cubes of
    // their size around and among them, each of which is looked up once.
    void over(std::size_t begin, std::size_t end, int level) const {
        if (level == 0) return visit_(begin);
        const int below = level - 1;
        const Cell origin = corner(bricks_[begin].first, level);
        std::array<Owners, 64> around;
        for (std::int32_t n = 0; n < 64; ++n)
            around[static_cast<std::size_t>(n)] = owners(origin, {n % 4 - 1, n / 4 % 4 - 1, n / 16 - 1}, below);
        for (std::size_t from = begin; from < end;) {
            const BrickKey last = bricks_[from].first | ((BrickKey{1} << 3 * below) - 1);
            const auto after =
                std::upper_bound(bricks_.begin() + static_cast<std::ptrdiff_t>(from), bricks_.begin() + static_cast<std::ptrdiff_t>(end),
                                 last, [](BrickKey key, const auto& brick) { return key < brick.first; });
            const auto to = static_cast<std::size_t>(after - bricks_.begin());
            const Cell part = corner(bricks_[from].first, below) - origin;
            if (may_have_border(around, {part.x >> below, part.y >> below, part.z >> below})) over(from, to, below);
            from = to;
        }
    }

  private:
    // Of the bricks in a cube. Owners ascend along the curve, so those at the ends of a cube are the least and the greatest of it.
    struct Owners {
        int least, greatest;
    };
    Cell corner(BrickKey key, int level) const {
        const std::int32_t side = std::int32_t{1} << level;
        const Cell any = lattice_.brick_at(key);
        return {any.x & -side, any.y & -side, any.z & -side};
    }
    // Beyond the limits of the world, and beside a plane, nobody owns anything.
    Owners owners(Cell origin, Cell step, int level) const {
        const Cell there = origin + Cell{step.x << level, step.y << level, step.z << level};
        if ((lattice_.flat() && step.z != 0) || !lattice_.brick_in_range(there)) return {partition_.processes(), -1};
        const BrickKey inside = (BrickKey{1} << 3 * level) - 1;
        const BrickKey first = lattice_.brick_key(there) & ~inside;
        return {partition_.owner(first), partition_.owner(first | inside)};
    }
    // Whether there may be a brick of the border in this part, of two each way, of a cube.
    bool may_have_border(const std::array<Owners, 64>& around, Cell part) const {
        int least = partition_.processes(), greatest = -1;
        bool with = !of_;
        for (u32 n = 0; n < kBrickNeighbours; ++n) {
            const Cell at = part + world::Lattice::brick_offset(n) + Cell{1, 1, 1};
            const Owners& there = around[static_cast<std::size_t>(at.x + 4 * at.y + 16 * at.z)];
            least = std::min(least, there.least);
            greatest = std::max(greatest, there.greatest);
            with = with || (there.least <= *of_ && *of_ <= there.greatest);
        }
        return with && least < greatest;
    }

    const Partition& partition_;
    const world::Lattice& lattice_;
    const std::span<const std::pair<BrickKey, std::uint32_t>> bricks_;
    const std::optional<int> of_;
    const std::function<void(std::size_t)>& visit_;
};

}  // namespace

void each_border_brick(const Partition& partition, const world::Lattice& lattice,
                       std::span<const std::pair<BrickKey, std::uint32_t>> bricks, std::optional<int> of,
                       const std::function<void(std::size_t index)>& visit) {
    if (partition.processes() == 1 || bricks.empty()) return;
    // From the smallest cube that has them all, but none that is partly beyond the limits of the world.
    int level = 1, largest = world::kHilbertBits;
    for (std::size_t axis = 0; axis < (lattice.flat() ? 2u : 3u); ++axis)
        largest = std::min(largest, std::countr_zero(static_cast<unsigned>(world::kCellLimit >> lattice.brick_bits()[axis])));
    while (level < largest && (bricks.front().first ^ bricks.back().first) >> 3 * level != 0) ++level;
    const BorderWalk walk(partition, lattice, bricks, of, visit);
    for (std::size_t from = 0; from < bricks.size();) {
        const BrickKey cube = bricks[from].first >> 3 * level;
        std::size_t to = from;
        while (to < bricks.size() && bricks[to].first >> 3 * level == cube) ++to;
        walk.over(from, to, level);
        from = to;
    }
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
    // Which of the new bricks are at a border is found for all at once, from a list along the curve.
    const std::size_t first = border_.size();
    std::vector<std::pair<BrickKey, std::uint32_t>> fresh;
    for (std::size_t slot = std::max<std::size_t>(1, first); slot <= ensemble_.brick_count(); ++slot)
        fresh.emplace_back(ensemble_.brick_key(static_cast<world::Slot>(slot)), static_cast<std::uint32_t>(slot));
    std::ranges::sort(fresh);
    constexpr std::int32_t kInside = -1, kBorder = 0;
    border_.resize(ensemble_.brick_count() + 1, kBorder);
    border_[0] = kInside;  // The empty slot.
    for (const auto& [key, slot] : fresh)
        if (partition_.owner(key) == process_) border_[slot] = kInside;
    each_border_brick(partition_, lattice(), fresh, process_, [&](std::size_t i) { border_[fresh[i].second] = kBorder; });
    for (std::size_t slot = first; slot < border_.size(); ++slot) {
        if (border_[slot] == kInside) continue;
        border_[slot] = static_cast<std::int32_t>(sides_.size());
        sides_.push_back(sides(ensemble_.brick(static_cast<world::Slot>(slot))));
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
