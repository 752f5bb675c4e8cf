// The block grid as a broadphase of its own; the engine uses the same search and builds its contacts from it at once.
#include "physics/broadphase.h"

#include <algorithm>

#include "physics/block_grid.h"
#include "physics/pair_search.h"

namespace meld::physics {

namespace {

class BlockBroadphase final : public Broadphase {
  public:
    Result<void> find(Bodies& bodies, double reach_m, Workers& workers) override {
        const RadiusRange radii = radius_range(bodies);
        const GridShape shape = GridShape::fitting(radii.min, radii.max, reach_m);
        if (auto built = grid_.build(bodies, shape, reach_m, workers, order_); !built) return built;
        const auto threads = static_cast<std::size_t>(workers.threads());
        pairs.resize(threads);
        searches_.resize(threads);
        for (auto& list : pairs) list.clear();
        workers.run(grid_.blocks().size(), [&](int worker, std::size_t block) {
            PairSearch& search = searches_[static_cast<std::size_t>(worker)];
            search.search(grid_, bodies, static_cast<std::uint32_t>(block), reach_m);
            for (const BodyPair pair : search.pairs())
                pairs[static_cast<std::size_t>(worker)].push_back({search.slots()[pair.first], search.slots()[pair.second]});
        });
        return {};
    }

  private:
    BlockGrid grid_;
    std::vector<PairSearch> searches_;
    Buffer<std::uint32_t> order_;
};

}  // namespace

std::unique_ptr<Broadphase> make_block_broadphase() { return std::make_unique<BlockBroadphase>(); }

RadiusRange radius_range(const Bodies& bodies) {
    RadiusRange range;
    bool first = true;
    for (std::size_t slot = 0; slot < bodies.count(); ++slot) {
        if (bodies.properties[slot].flags & kRemoved) continue;
        const double radius = bodies.place[slot].radius;
        range = first ? RadiusRange{radius, radius} : RadiusRange{std::min(range.min, radius), std::max(range.max, radius)};
        first = false;
    }
    return range;
}

}  // namespace meld::physics
