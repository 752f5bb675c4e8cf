#include "physics/statics/stiff_lattice.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

constexpr std::uint32_t kNotLeft = 0xffffffff;

// A round bar of steel as long as thick, relative to its stiffness along: E A/l = 1, G A/l, E I/l and G J/l.
constexpr double kShear = 0.4, kBending = 0.25, kTwist = 0.2;

// Blocks that an elimination may keep: of small nets always enough.
constexpr std::size_t kBlocksPerBody = 12, kBlocksAnyway = 6000;
// More bodies than this are grouped.
constexpr std::size_t kFewBodies = 60;
constexpr int kMostSteps = 1000, kInnerSteps = 2;
constexpr double kLeftShare = 1e-7;
// Of a direct solution, which is as good as the numbers of the machine let it be.
constexpr double kLeftShareDirect = 1e-4;

Matrix6 stiffness_of(const Beam& beam, double radius) {
    const double e[] = {beam.along.x, beam.along.y, beam.along.z}, square = radius * radius;
    Matrix6 m = Matrix6::Zero();
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
            const double same = i == k ? 1 : 0;
            m(i, k) = kShear * same + (1 - kShear) * e[i] * e[k];
            m(3 + i, 3 + k) = square * (kBending * same + (kTwist - kBending) * e[i] * e[k]);
        }
    return m;
}

double product(const Twists& a, const Twists& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
    return sum;
}

// to = a to + b from
void blend(double a, Twists& to, double b, const Twists& from) {
    for (std::size_t i = 0; i < to.size(); ++i) to[i] = a * to[i] + b * from[i];
}

}  // namespace

StiffLattice::StiffLattice(std::vector<Vec3> places, std::vector<Beam> beams) : places_(std::move(places)), beams_(std::move(beams)) {
    if (beams_.empty()) return;
    unit_m_ = beams_.front().radius_m;
    const std::vector<std::uint8_t> carries_alone = peel();
    left_.assign(places_.size(), kNotLeft);
    std::vector<std::uint8_t> in_loop(places_.size(), 0);
    bool grounded = false;
    for (std::uint32_t b = 0; b < beams_.size(); ++b) {
        if (carries_alone[b] != 0) continue;
        left_beams_.push_back(b);
        in_loop[beams_[b].one] = 1;
        if (beams_[b].other == kGround)
            grounded = true;
        else
            in_loop[beams_[b].other] = 1;
    }
    if (left_beams_.empty()) return;
    // If nothing holds the rest, its first body is taken for the ground: in balance it needs no holding.
    std::vector<Vec3> of_left;
    for (std::size_t body = 0; body < places_.size(); ++body) {
        if (in_loop[body] == 0) continue;
        if (!std::exchange(grounded, true)) continue;
        left_[body] = static_cast<std::uint32_t>(of_left.size());
        of_left.push_back((1 / unit_m_) * places_[body]);
    }
    std::vector<Spring> springs;
    for (const std::uint32_t b : left_beams_) {
        const Beam& beam = beams_[b];
        std::uint32_t one = left_[beam.one], other = beam.other == kGround ? kGround : left_[beam.other];
        if (one == kNotLeft) std::swap(one, other);
        MELD_CHECK(one != kNotLeft, "a beam between two places that do not move");
        springs.push_back({.one = one,
                           .other = other == kNotLeft ? kGround : other,
                           .at = (1 / unit_m_) * beam.at,
                           .stiffness = stiffness_of(beam, beam.radius_m / unit_m_)});
    }
    lay_out(std::move(of_left), std::move(springs));
}

std::vector<std::uint8_t> StiffLattice::peel() {
    std::vector<std::vector<std::uint32_t>> of_body(places_.size());
    for (std::uint32_t b = 0; b < beams_.size(); ++b) {
        of_body[beams_[b].one].push_back(b);
        if (beams_[b].other != kGround) of_body[beams_[b].other].push_back(b);
    }
    std::vector<std::uint8_t> carries_alone(beams_.size(), 0);
    std::vector<std::size_t> degree(places_.size());
    std::vector<std::uint32_t> ends;
    for (std::uint32_t body = 0; body < places_.size(); ++body)
        if (degree[body] = of_body[body].size(); degree[body] == 1) ends.push_back(body);
    for (std::size_t i = 0; i < ends.size(); ++i) {
        const std::uint32_t body = ends[i];
        if (degree[body] != 1) continue;
        const auto beam = *std::ranges::find_if(of_body[body], [&](std::uint32_t b) { return carries_alone[b] == 0; });
        carries_alone[beam] = 1;
        peeled_.push_back({body, beam});
        degree[body] = 0;
        const std::uint32_t next = beams_[beam].one == body ? beams_[beam].other : beams_[beam].one;
        if (next != kGround && --degree[next] == 1) ends.push_back(next);
    }
    return carries_alone;
}

void StiffLattice::lay_out(std::vector<Vec3> places, std::vector<Spring> springs) {
    levels_.push_back({SpringNet(std::move(places), std::move(springs)), {}});
    while (true) {
        Level& last = levels_.back();
        direct_ = Elimination::of(last.net, kBlocksPerBody * last.net.count() + kBlocksAnyway);
        if (direct_ || last.net.count() <= kFewBodies) return;
        SpringNet next = last.net.coarser(last.group_of);
        if (next.count() == last.net.count()) return;
        levels_.push_back({std::move(next), {}});
    }
}

bool StiffLattice::solve(std::span<const Pull> on_bodies, std::span<Pull> by_beams) const {
    MELD_EXPECT(on_bodies.size() == places_.size() && by_beams.size() == beams_.size(), "{} bodies, {} beams", on_bodies.size(),
                by_beams.size());
    std::vector<Pull> acts(on_bodies.begin(), on_bodies.end());
    for (const auto& [body, index] : peeled_) {
        const Beam& beam = beams_[index];
        const Vec3 arm = places_[body] - beam.at;
        const Pull at_beam{acts[body].force, acts[body].torque + cross(arm, acts[body].force)};
        const double side = beam.one == body ? -1 : 1;
        by_beams[index] = {side * at_beam.force, side * at_beam.torque};
        const std::uint32_t next = beam.one == body ? beam.other : beam.one;
        if (next == kGround) continue;
        acts[next].force = acts[next].force + at_beam.force;
        acts[next].torque = acts[next].torque + (at_beam.torque + cross(beam.at - places_[next], at_beam.force));
    }
    if (levels_.empty()) return true;
    Twists on_left(levels_.front().net.count()), x;
    for (std::size_t body = 0; body < places_.size(); ++body)
        if (left_[body] != kNotLeft) on_left[left_[body]] = six(acts[body].force, (1 / unit_m_) * acts[body].torque);
    bool found = true;
    if (levels_.size() == 1 && direct_) {
        x = on_left;
        direct_->solve(x);
        // A slender shape bends so far that what is left of rounding counts.
        Twists left;
        levels_.front().net.multiply(x, left);
        blend(-1, left, 1, on_left);
        found = product(left, left) <= kLeftShareDirect * kLeftShareDirect * product(on_left, on_left);
    } else {
        found = iterate(0, on_left, x, kMostSteps, kLeftShare);
    }
    for (const std::uint32_t index : left_beams_) {
        const Beam& beam = beams_[index];
        const auto moved = [&](std::uint32_t body) -> Vector6 {
            if (body == kGround || left_[body] == kNotLeft) return Vector6::Zero();
            return displaced(x[left_[body]], (1 / unit_m_) * (beam.at - places_[body]));
        };
        const Vector6 pulls = stiffness_of(beam, beam.radius_m / unit_m_) * (moved(beam.other) - moved(beam.one));
        by_beams[index] = {first_of(pulls), unit_m_ * second_of(pulls)};
    }
    return found;
}

bool StiffLattice::iterate(std::size_t level, const Twists& acts, Twists& x, int most_steps, double share) const {
    const SpringNet& net = levels_[level].net;
    x.assign(net.count(), Vector6::Zero());
    Twists left = acts, way, next, answer;
    const double goal = share * share * product(acts, acts);
    double stiff = 0;
    for (int step = 0; step < most_steps; ++step) {
        if (product(left, left) <= goal) return true;
        precondition(level, left, next);
        if (step == 0) {
            way = next;
        } else {
            blend(-product(next, answer) / stiff, way, 1, next);
        }
        net.multiply(way, answer);
        stiff = product(way, answer);
        if (!(stiff > 0)) break;
        const double far = product(way, left) / stiff;
        blend(1, x, far, way);
        blend(1, left, -far, answer);
    }
    return product(left, left) <= goal;
}

void StiffLattice::precondition(std::size_t level, const Twists& acts, Twists& x) const {
    const Level& here = levels_[level];
    if (level + 1 == levels_.size() && direct_) {
        x = acts;
        direct_->solve(x);
        return;
    }
    x.assign(here.net.count(), Vector6::Zero());
    here.net.sweep(acts, x, SpringNet::Order::Forward);
    if (level + 1 < levels_.size()) {
        const SpringNet& groups = levels_[level + 1].net;
        Twists left, on_groups, of_groups;
        here.net.multiply(x, left);
        blend(-1, left, 1, acts);
        here.net.gather(here.group_of, groups, left, on_groups);
        if (level + 2 == levels_.size())
            precondition(level + 1, on_groups, of_groups);
        else
            iterate(level + 1, on_groups, of_groups, kInnerSteps, 0);
        here.net.spread(here.group_of, groups, of_groups, x);
    }
    here.net.sweep(acts, x, SpringNet::Order::Backward);
}

std::size_t StiffLattice::bytes() const {
    std::size_t sum = places_.capacity() * sizeof(Vec3) + beams_.capacity() * sizeof(Beam) + peeled_.capacity() * sizeof(Peeled) +
                      (left_.capacity() + left_beams_.capacity()) * sizeof(std::uint32_t);
    for (const Level& level : levels_) sum += level.net.bytes() + level.group_of.capacity() * sizeof(std::uint32_t);
    return sum + (direct_ ? direct_->bytes() : 0);
}

}  // namespace meld::physics
