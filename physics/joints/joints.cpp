#include "physics/joints/joints.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "physics/bodies/denormals.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

std::pair<BodyId, BodyId> in_order(BodyId one, BodyId other) { return std::minmax(one, other); }
std::pair<BodyId, BodyId> key_of(const Joint& joint) { return in_order(joint.first, joint.second); }

bool is_sound(const Joint& joint) {
    for (const Vec3& v :
         {joint.first_anchor, joint.second_anchor, joint.first_axis, joint.second_axis, joint.across, joint.pushed, joint.twisted})
        if (!is_finite(v)) return false;
    for (const double value : joint.impulses)
        if (!std::isfinite(value)) return false;
    for (const double value : {joint.strength, joint.stiffness, joint.damping, joint.rest, joint.target, joint.place, joint.sum_s})
        if (!std::isfinite(value)) return false;
    for (const JointLoad& load : {joint.sum, joint.load})
        if (!std::isfinite(load.tension_n + load.shear_n + load.torque_nm)) return false;
    return joint.kind <= JointKind::Ball && joint.drive <= JointDrive::Kind::Brake && joint.stand <= JointStand::Minus &&
           joint.lower <= joint.upper && joint.breaking_force > 0 && joint.breaking_torque > 0 && joint.first != joint.second &&
           joint.first < kMaxBodies && joint.second < kMaxBodies;
}

// All joints of one body or composite are coupled with each other, which is not the fault of loops.
Result<void> check_hubs(std::span<const Joint> joints, const Movers& movers) {
    std::map<BodyId, std::size_t> counts;
    for (const Joint& joint : joints)
        if (const BodyId first = movers.of(joint.first), second = movers.of(joint.second); first != second)
            ++counts[first], ++counts[second];
    for (const auto& [body, count] : counts)
        if (body != kMaxBodies && count > kMaxJointsOfBody)
            return fail(
                fmt::format("body {}{} has {} joints (a body that moves has {} at most)", body,
                            movers.composite_of(body) == kNoComposite ? "" : " with all that are connected to it", count, kMaxJointsOfBody),
                "Join some to another one, or make it fixed");
    return {};
}

}  // namespace

std::vector<Joint>::iterator Joints::place_of_pair(BodyId one, BodyId other) {
    return std::ranges::lower_bound(joints_, in_order(one, other), {}, key_of);
}

const Joint* Joints::find(BodyId one, BodyId other) const {
    const std::pair<BodyId, BodyId> key = in_order(one, other);
    const auto found = std::ranges::lower_bound(joints_, key, {}, key_of);
    return found == joints_.end() || key_of(*found) != key ? nullptr : &*found;
}

void Joints::add(const Joint& joint) {
    MELD_EXPECT(find(joint.first, joint.second) == nullptr, "bodies {} and {}", joint.first, joint.second);
    joints_.insert(place_of_pair(joint.first, joint.second), joint);
    changed_ = true;
}

void Joints::remove_all(BodyId body) {
    if (std::erase_if(joints_, [&](const Joint& joint) { return joint.first == body || joint.second == body; }) > 0) changed_ = true;
}

void Joints::remove(BodyId one, BodyId other) {
    const auto found = place_of_pair(one, other);
    MELD_EXPECT(found != joints_.end() && key_of(*found) == in_order(one, other), "bodies {} and {}", one, other);
    joints_.erase(found);
    changed_ = true;
}

void Joints::drive(BodyId one, BodyId other, const JointDrive& drive) {
    const auto found = place_of_pair(one, other);
    MELD_EXPECT(found != joints_.end() && key_of(*found) == in_order(one, other), "bodies {} and {}", one, other);
    found->drive = drive.kind, found->target = drive.target;
    driven_ = true;
}

Result<void> Joints::settle(const Movers& movers) {
    if (!changed_) {
        for (Assembly& assembly : assemblies_) assembly.locate(movers);
        lone_.locate(assemblies_, movers.bodies, movers.shapes);
        return {};
    }
    changed_ = !lay_out(movers);
    if (!changed_) return {};
    if (auto fine = check_hubs(joints_, movers); !fine) return fine;
    return fail("joints hold bodies together in too many loops to be solved", "Use fewer joints, or connect bodies rigidly");
}

void Joints::add_all(std::span<const Joint> more) {
    if (more.empty()) return;
    joints_.insert(joints_.end(), more.begin(), more.end());
    std::ranges::sort(joints_, {}, key_of);
    MELD_CHECK(std::ranges::adjacent_find(joints_, {}, key_of) == joints_.end(), "two bodies have two joints");
    changed_ = true;
}

void Joints::keep(const std::vector<bool>& chosen) {
    MELD_EXPECT(chosen.size() == joints_.size(), "{} of {} joints", chosen.size(), joints_.size());
    std::size_t kept = 0;
    for (std::size_t j = 0; j < joints_.size(); ++j)
        if (chosen[j]) joints_[kept++] = joints_[j];
    if (kept == joints_.size()) return;
    joints_.resize(kept);
    changed_ = true;
}

Joints::Groups Joints::groups(const std::function<BodyId(BodyId)>& mover) const {
    std::map<BodyId, BodyId> above;
    // The movers of each joint.
    std::vector<std::pair<BodyId, BodyId>> ends;
    ends.reserve(joints_.size());
    for (const Joint& joint : joints_) ends.emplace_back(mover(joint.first), mover(joint.second));
    const auto lowest = [&](BodyId body) {
        while (above.at(body) != body) body = above[body] = above.at(above.at(body));
        return body;
    };
    for (const auto& [first, second] : ends)
        for (const BodyId body : {first, second})
            if (body != kMaxBodies) above.emplace(body, body);
    for (const auto& [first, second] : ends) {
        if (first == kMaxBodies || second == kMaxBodies) continue;
        const BodyId one = lowest(first), other = lowest(second);
        above[std::max(one, other)] = std::min(one, other);
    }
    Groups groups;
    for (std::uint32_t j = 0; j < joints_.size(); ++j) {
        const BodyId moved = std::min(ends[j].first, ends[j].second);
        groups[moved == kMaxBodies ? joints_[j].first : lowest(moved)].push_back(j);
    }
    return groups;
}

Joints::Groups Joints::groups(const Movers& movers) const {
    return groups([&](BodyId body) { return movers.of(body); });
}

bool Joints::lay_out(const Movers& movers) {
    assemblies_.clear();
    bool fine = true;
    for (auto& [body, list] : groups(movers)) {
        std::erase_if(list, [&](std::uint32_t j) {
            Joint& joint = joints_[j];
            if (movers.of(joint.first) != movers.of(joint.second)) return false;
            joint.impulses = {}, joint.load = {};
            joint.stand = JointStand::Free;
            return true;
        });
        if (!list.empty()) fine = assemblies_.emplace_back().lay_out(list, joints_, movers) && fine;
    }
    lone_.lay_out(assemblies_, joints_, movers.bodies, movers.shapes);
    return fine;
}

void Joints::places_changed() {
    for (Assembly& assembly : assemblies_) assembly.places_changed();
    lone_.places_changed();
}

void Joints::forget_impulses() {
    for (Joint& joint : joints_) {
        joint.impulses = {};
        joint.stand = JointStand::Free;
    }
    lone_.forget_impulses();
}

void Joints::forget_step() {
    lone_.forget_step();
    for (Joint& joint : joints_) joint.pushed = joint.twisted = {};
}

void Joints::end_step(const Movers& movers, double dt_s, Workers& workers) {
    broken_.clear();
    if (joints_.empty()) return;
    breaks_.assign(assemblies_.size(), std::nullopt);
    for_assemblies(
        workers, [&](std::size_t batch) { return lone_.end_step(batch, joints_, movers.bodies, dt_s, breaks_); },
        [&](std::uint32_t a) { breaks_[a] = assemblies_[a].end_step(joints_, movers, dt_s); });
    for (const auto& index : breaks_)
        if (index) broken_.push_back(key_of(joints_[*index]));
    std::ranges::sort(broken_);
    for (const auto& [one, other] : broken_) remove(one, other);
}

void Joints::take_loads() {
    for (Joint& joint : joints_) {
        if (joint.sum_s == 0) continue;
        const double share = 1 / std::exchange(joint.sum_s, 0);
        const JointLoad sum = std::exchange(joint.sum, {});
        joint.load = {share * sum.tension_n, share * sum.shear_n, share * sum.torque_nm};
    }
}

void Joints::warm_start(const Movers& movers, Workers& workers) {
    for_assemblies(
        workers, [&](std::size_t batch) { return lone_.warm_start(batch, joints_, movers.bodies); },
        [&](std::uint32_t a) { assemblies_[a].warm_start(joints_, movers); });
}

void Joints::run(Assembly::Phase phase, const Movers& movers, double step_s, Workers& workers) {
    for_assemblies(
        workers, [&](std::size_t batch) { return lone_.run(batch, phase, joints_, movers.bodies, step_s); },
        [&](std::uint32_t a) { assemblies_[a].run(phase, joints_, movers, step_s); });
}

template <class OfBatch, class OfAssembly>
void Joints::for_assemblies(Workers& workers, const OfBatch& of_batch, const OfAssembly& of_assembly) {
    if (std::exchange(driven_, false)) lone_.drives_changed();
    const std::size_t batches = lone_.batches();
    const std::span<const std::uint32_t> others = lone_.others();
    workers.run(batches + others.size(), [&](int, std::size_t i) {
        const FlushDenormals flush;
        if (i >= batches) return of_assembly(others[i - batches]);
        const LoneJoints::Chosen left = of_batch(i);
        for (std::size_t k = 0; k < LoneJoints::kAtOnce; ++k)
            if ((left & 1U << k) != 0) of_assembly(lone_.assembly(i, k));
    });
}

void Joints::write(ByteWriter& out) const { write(out, std::vector<bool>(joints_.size(), true)); }

void Joints::write(ByteWriter& out, const std::vector<bool>& chosen) const {
    MELD_EXPECT(chosen.size() == joints_.size(), "{} of {} joints", chosen.size(), joints_.size());
    out.write_count(static_cast<std::size_t>(std::ranges::count(chosen, true)));
    for (std::size_t j = 0; j < joints_.size(); ++j)
        if (chosen[j]) out.write(joints_[j]);
}

bool Joints::read(ByteReader& in) {
    for (auto left = in.read_count(sizeof(Joint)); left > 0; --left) joints_.push_back(in.read<Joint>());
    changed_ = true;
    if (in.failed() || !std::ranges::all_of(joints_, is_sound)) return false;
    std::ranges::sort(joints_, {}, key_of);
    return std::ranges::adjacent_find(joints_, {}, key_of) == joints_.end();
}

bool Joints::fits(const Bodies& bodies) const {
    return std::ranges::all_of(joints_, [&](const Joint& joint) {
        if (!bodies.has(joint.first) || !bodies.has(joint.second)) return false;
        return ((bodies.properties[bodies.slot(joint.first)].flags & bodies.properties[bodies.slot(joint.second)].flags) & kFixed) == 0;
    });
}

std::size_t Joints::bytes() const {
    std::size_t sum = joints_.capacity() * sizeof(Joint) + assemblies_.capacity() * sizeof(Assembly) +
                      breaks_.capacity() * sizeof(breaks_[0]) + broken_.capacity() * sizeof(broken_[0]);
    for (const Assembly& assembly : assemblies_) sum += assembly.bytes();
    sum += lone_.bytes();
    return sum;
}

}  // namespace meld::physics
