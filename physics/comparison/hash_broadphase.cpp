// The original design's broadphase: multi-scale bins filled by atomic exchange, and a vector of n bits for each thread.
#include <algorithm>
#include <atomic>
#include <cmath>

#include "physics/comparison/hash_broadphase.h"
#include "runtime/base/hash.h"

namespace meld::physics {

namespace {

constexpr std::size_t kSlotsPerJob = 1024;
constexpr std::uint32_t kEnd = 0xffffffff;
// A body's box is at most a cell wide, so it overlaps at most two cells along each axis.
constexpr std::size_t kMaxBins = 8;

class HashBroadphase final : public Broadphase {
  public:
    Result<void> find(Bodies& bodies, double reach_m, Workers& workers) override {
        const std::size_t count = bodies.count();
        prepare(bodies, reach_m, workers);
        const std::size_t jobs = (count + kSlotsPerJob - 1) / kSlotsPerJob;
        workers.run(jobs, [&](int, std::size_t job) {
            for (std::size_t i = job * kSlotsPerJob; i < std::min(count, (job + 1) * kSlotsPerJob); ++i)
                insert(bodies, static_cast<std::uint32_t>(i));
        });
        workers.run(jobs, [&](int worker, std::size_t job) {
            for (std::size_t i = job * kSlotsPerJob; i < std::min(count, (job + 1) * kSlotsPerJob); ++i)
                query(bodies, static_cast<std::uint32_t>(i), worker);
        });
        return {};
    }

  private:
    struct Node {
        std::uint32_t body, next;
    };
    struct Met {
        std::vector<std::uint64_t> bits;
        std::vector<std::uint32_t> list;
    };

    void prepare(const Bodies& bodies, double reach_m, const Workers& workers) {
        const std::size_t count = bodies.count();
        half_reach_ = reach_m / 2;
        const RadiusRange radii = radius_range(bodies);
        cell_m_ = 2 * radii.min + reach_m;
        levels_ = 1;
        while (cell_m_ * std::exp2(levels_ - 1) < 2 * radii.max + reach_m) ++levels_;
        std::size_t size = 1024;
        while (size < 4 * count) size *= 2;
        if (heads_.size() != size) heads_ = std::vector<std::atomic<std::uint32_t>>(size);
        for (auto& head : heads_) head.store(kEnd, std::memory_order_relaxed);
        nodes_.resize(count * kMaxBins);
        const auto threads = static_cast<std::size_t>(workers.threads());
        pairs.resize(threads);
        for (auto& list : pairs) list.clear();
        met_.resize(threads);
        for (Met& met : met_) met.bits.assign((count + 63) / 64, 0);
    }

    int level_of(double radius) const {
        int level = 0;
        while (cell_m_ * std::exp2(level) < 2 * (radius + half_reach_) && level + 1 < levels_) ++level;
        return level;
    }

    // Calls f(bin) for each cell of a level that the box around a body overlaps.
    template <class F>
    void for_bins(const Place& p, int level, const F& f) const {
        const double cell = cell_m_ * std::exp2(level), r = p.radius + half_reach_;
        const auto at = [cell](double position) { return static_cast<std::int64_t>(std::floor(position / cell)); };
        for (std::int64_t z = at(p.z - r); z <= at(p.z + r); ++z)
            for (std::int64_t y = at(p.y - r); y <= at(p.y + r); ++y)
                for (std::int64_t x = at(p.x - r); x <= at(p.x + r); ++x) {
                    const std::uint64_t key =
                        hash_combine(hash_combine(static_cast<std::uint64_t>(x) ^ static_cast<std::uint64_t>(level) << 56,
                                                  static_cast<std::uint64_t>(y)),
                                     static_cast<std::uint64_t>(z));
                    f(key & (heads_.size() - 1));
                }
    }

    void insert(const Bodies& bodies, std::uint32_t body) {
        if (bodies.properties[body].flags & kRemoved) return;
        const Place& p = bodies.place[body];
        std::size_t node = body * kMaxBins;
        for_bins(p, level_of(p.radius), [&](std::size_t bin) {
            if (node == (body + 1u) * kMaxBins) return;
            nodes_[node].body = body;
            nodes_[node].next = heads_[bin].exchange(static_cast<std::uint32_t>(node), std::memory_order_acq_rel);
            ++node;
        });
    }

    void query(const Bodies& bodies, std::uint32_t body, int worker) {
        if (bodies.properties[body].flags & kRemoved) return;
        const Place& p = bodies.place[body];
        const int own = level_of(p.radius);
        Met& met = met_[static_cast<std::size_t>(worker)];
        for (int level = own; level < levels_; ++level)
            for_bins(p, level, [&](std::size_t bin) {
                for (std::uint32_t at = heads_[bin].load(std::memory_order_relaxed); at != kEnd; at = nodes_[at].next)
                    meet(bodies, body, own, nodes_[at].body, met, worker);
            });
        for (const std::uint32_t other : met.list) met.bits[other / 64] = 0;
        met.list.clear();
    }

    void meet(const Bodies& bodies, std::uint32_t body, int own_level, std::uint32_t other, Met& met, int worker) {
        // Of two bodies of one level the one with the lower slot finds the other; a smaller one finds a larger one.
        const int level = level_of(bodies.place[other].radius);
        if (level < own_level || (level == own_level && other <= body)) return;
        const std::uint64_t bit = std::uint64_t{1} << (other % 64);
        if (met.bits[other / 64] & bit) return;
        met.bits[other / 64] |= bit;
        met.list.push_back(other);
        const Place &p = bodies.place[body], &q = bodies.place[other];
        const double dx = q.x - p.x, dy = q.y - p.y, dz = q.z - p.z, reach = p.radius + q.radius + 2 * half_reach_;
        if (dx * dx + dy * dy + dz * dz >= reach * reach) return;
        if (bodies.properties[body].flags & bodies.properties[other].flags & kFixed) return;
        pairs[static_cast<std::size_t>(worker)].push_back({body, other});
    }

    double cell_m_ = 1, half_reach_ = 0;
    int levels_ = 1;
    std::vector<std::atomic<std::uint32_t>> heads_;
    Buffer<Node> nodes_;
    std::vector<Met> met_;
};

}  // namespace

std::unique_ptr<Broadphase> make_hash_broadphase() { return std::make_unique<HashBroadphase>(); }

}  // namespace meld::physics
