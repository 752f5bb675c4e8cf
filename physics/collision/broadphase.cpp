// The block grid as a broadphase alone; the engine uses the same search and builds its contacts directly from it.
#include "physics/collision/broadphase.h"

#include <algorithm>
#include <cmath>

#include "physics/collision/block_grid.h"
#include "physics/collision/pair_search.h"

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
            search.search(grid_, bodies, static_cast<std::uint32_t>(block), {.apart_m = reach_m});
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

void Velocities::add(const Vec3& v) {
    least_ = {std::min(least_.x, v.x), std::min(least_.y, v.y), std::min(least_.z, v.z)};
    most_ = {std::max(most_.x, v.x), std::max(most_.y, v.y), std::max(most_.z, v.z)};
    x_.add(v.x), y_.add(v.y), z_.add(v.z);
    ++of_exponent_[static_cast<std::size_t>(exponent_of(dot(v, v)))];
    ++count_;
}

void Velocities::add(const Velocities& others) {
    const Vec3 &l = others.least_, &m = others.most_;
    least_ = {std::min(least_.x, l.x), std::min(least_.y, l.y), std::min(least_.z, l.z)};
    most_ = {std::max(most_.x, m.x), std::max(most_.y, m.y), std::max(most_.z, m.z)};
    x_.add(others.x_), y_.add(others.y_), z_.add(others.z_);
    for (std::size_t i = 0; i < of_exponent_.size(); ++i) of_exponent_[i] += others.of_exponent_[i];
    count_ += others.count_;
}

Vec3 Velocities::mean() const {
    if (count_ == 0) return {};
    return (1 / static_cast<double>(count_)) * Vec3{x_.value(), y_.value(), z_.value()};
}

double Velocities::greatest_beside(const Vec3& m) const {
    if (count_ == 0) return 0;
    return length(
        {std::max(most_.x - m.x, m.x - least_.x), std::max(most_.y - m.y, m.y - least_.y), std::max(most_.z - m.z, m.z - least_.z)});
}

int Velocities::exponent_of(double speed_squared) {
    return speed_squared > 0 ? std::clamp(std::ilogb(speed_squared) + kExponents / 2, 0, kExponents - 1) : 0;
}

double Velocities::share_above(double speed_m_s) const {
    MELD_EXPECT(speed_m_s > 0, "{} m/s", speed_m_s);
    std::uint64_t faster = 0;
    for (int i = exponent_of(speed_m_s * speed_m_s); i < kExponents; ++i) faster += of_exponent_[static_cast<std::size_t>(i)];
    return count_ == 0 ? 0 : static_cast<double>(faster) / static_cast<double>(count_);
}

Velocities velocities_of(const Bodies& bodies) {
    Velocities all;
    for (std::size_t slot = 0; slot < bodies.count(); ++slot) {
        if (bodies.properties[slot].flags & (kRemoved | kGhost)) continue;
        const Vec3 velocity = velocity_of(bodies.velocity[slot]);
        if (is_finite(velocity)) all.add(velocity);
    }
    return all;
}

}  // namespace meld::physics
