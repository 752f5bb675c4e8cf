// What processes have to tell each other, for cubes of catoms and numbers of processes that fit on no machine here: owners of bricks as a
// run has them, and the catoms that others read. Usage: bench_halo [SIDES IN CELLS...]
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <span>
#include <vector>

#include "runtime/world/partition/partition.h"
#include "tests/bench/clock.h"

namespace {

using namespace meld;
using partition::Partition;
using world::Cell;

constexpr int kEdge = 8;  // Cells along a brick.

struct Share {
    std::uint64_t catoms = 0, told = 0,
                  heard = 0;  // Its own; of these those that others read, once for each; those of others that it reads.
    std::set<int> neighbours;
};

// Cells of a brick fall into 27 classes: along each axis at the lower edge, between, or at the upper edge.
constexpr std::array<std::uint64_t, 3> kWide = {1, kEdge - 2, 1};

// Owners of the bricks of a cube, and the process of each of the 26 around one; outside nobody.
class Owners {
  public:
    Owners(const world::Lattice& lattice, int bricks, int processes)
        : bricks_(bricks), owner_(static_cast<std::size_t>(bricks) * static_cast<std::size_t>(bricks) * static_cast<std::size_t>(bricks)) {
        std::vector<std::pair<world::BrickKey, std::uint32_t>> counts;
        const int low = -bricks / 2;
        std::vector<world::BrickKey> keys(owner_.size());
        for (int z = 0; z < bricks; ++z)
            for (int y = 0; y < bricks; ++y)
                for (int x = 0; x < bricks; ++x) keys[at(x, y, z)] = lattice.brick_key({x + low, y + low, z + low});
        counts.reserve(keys.size());
        for (const world::BrickKey key : keys) counts.emplace_back(key, kBrickCells);
        std::sort(counts.begin(), counts.end());
        const Partition partition(counts, processes);
        for (std::size_t i = 0; i < keys.size(); ++i) owner_[i] = partition.owner(keys[i]);
    }
    int bricks() const { return bricks_; }
    int operator()(int x, int y, int z) const {
        const auto outside = [&](int c) { return c < 0 || c >= bricks_; };
        return outside(x) || outside(y) || outside(z) ? -1 : owner_[at(x, y, z)];
    }

  private:
    std::size_t at(int x, int y, int z) const {
        return (static_cast<std::size_t>(z) * static_cast<std::size_t>(bricks_) + static_cast<std::size_t>(y)) *
                   static_cast<std::size_t>(bricks_) +
               static_cast<std::size_t>(x);
    }
    int bricks_;
    std::vector<int> owner_;
};

std::vector<Share> shares_of(const Owners& owner, int processes) {
    std::vector<Share> shares(static_cast<std::size_t>(processes));
    const auto each = [](const auto& visit) {
        for (int z = -1; z <= 1; ++z)
            for (int y = -1; y <= 1; ++y)
                for (int x = -1; x <= 1; ++x) visit(x, y, z);
    };
    for (int z = 0; z < owner.bricks(); ++z)
        for (int y = 0; y < owner.bricks(); ++y)
            for (int x = 0; x < owner.bricks(); ++x) {
                const int mine = owner(x, y, z);
                Share& share = shares[static_cast<std::size_t>(mine)];
                share.catoms += kBrickCells;
                std::set<int> others;
                each([&](int dx, int dy, int dz) { others.insert(owner(x + dx, y + dy, z + dz)); });
                for (const int other : others) {
                    if (other < 0 || other == mine) continue;
                    std::uint64_t read = 0;
                    each([&](int cx, int cy, int cz) {
                        bool near = false;
                        each([&](int dx, int dy, int dz) {
                            const bool reaches = (dx == 0 || dx == cx) && (dy == 0 || dy == cy) && (dz == 0 || dz == cz);
                            near = near || (reaches && owner(x + dx, y + dy, z + dz) == other);
                        });
                        if (near)
                            read += kWide[static_cast<std::size_t>(cx + 1)] * kWide[static_cast<std::size_t>(cy + 1)] *
                                    kWide[static_cast<std::size_t>(cz + 1)];
                    });
                    share.told += read;
                    share.neighbours.insert(other);
                    shares[static_cast<std::size_t>(other)].heard += read;
                }
            }
    return shares;
}

}  // namespace

int main(int argc, char** argv) {
    bench::machine_line();
    std::vector<int> sides;
    for (int i = 1; i < argc; ++i) sides.push_back(std::atoi(argv[i]) / kEdge);
    if (sides.empty()) sides = {34, 58, 125};
    const world::Lattice lattice(world::LatticeKind::Cubic);
    std::printf("catoms, processes: of the busiest process its catoms, those of others that it reads, those that it tells, to how many\n");
    for (const int side : sides)
        for (const int processes : {2, 4, 16, 64, 256, 1000}) {
            const std::vector<Share> shares = shares_of(Owners(lattice, side, processes), processes);
            Share most;
            std::size_t neighbours = 0;
            for (const Share& share : shares) {
                most.catoms = std::max(most.catoms, share.catoms);
                most.told = std::max(most.told, share.told);
                most.heard = std::max(most.heard, share.heard);
                neighbours = std::max(neighbours, share.neighbours.size());
            }
            const auto all = static_cast<double>(side) * side * side * kBrickCells;
            std::printf("%.3g, %4d: %.4g, %.4g, %.4g (%.1f %% of its own), %zu\n", all, processes, static_cast<double>(most.catoms),
                        static_cast<double>(most.heard), static_cast<double>(most.told),
                        100 * static_cast<double>(most.told) / static_cast<double>(most.catoms), neighbours);
            std::fflush(stdout);
        }
    return 0;
}
