#include "physics/joints/assembly.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

// Rows give way by this share of what an impulse does, so that rows that others imply can be solved; only loops have such rows.
constexpr double kSoftnessOfTrees = 1e-12, kSoftnessOfLoops = 1e-6;
// How often a sweep may solve until all joints are in their places on their curves. All that are elsewhere move there at once; if that goes
// round in circles, as in loops, one after the other does.
constexpr int kMostSolutions = 36, kAllAtOnce = 6;
constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kInactive = -1;
// Of two joints that share both of their bodies.
constexpr std::uint32_t kBoth = 0xffffffff;

Vec3 heavy(const Vec3& moments, Quat turn, Vec3 spin) {
    const Vec3 own = rotate(conjugate(turn), spin);
    return rotate(turn, {moments.x * own.x, moments.y * own.y, moments.z * own.z});
}
Vec3 light(const Vec3& moments, Quat turn, Vec3 momentum) {
    const Vec3 own = rotate(conjugate(turn), momentum);
    return rotate(turn, {own.x / moments.x, own.y / moments.y, own.z / moments.z});
}

// As the pass over bodies turns them: by the tangent of half the angle.
Quat turned_in_step(Quat turn, Vec3 spin, double step_s) {
    const Vec3 half = (0.5 * step_s) * spin;
    return unit(product({1, half.x, half.y, half.z}, turn));
}

}  // namespace

JointPose joint_pose(const Bodies& bodies, std::uint32_t slot) {
    return {centre_of(bodies.place[slot]), unit(widened(bodies.orientation[slot]))};
}

bool Assembly::lay_out(std::vector<std::uint32_t> joints, std::span<const Joint> all, const Movers& movers) {
    joints_ = std::move(joints);
    const auto member_of = [&](BodyId body) {
        const BodyId mover = movers.of(body);
        return mover == kMaxBodies ? body : mover;
    };
    std::map<BodyId, std::uint32_t> index;
    for (const std::uint32_t j : joints_) index.emplace(member_of(all[j].first), 0), index.emplace(member_of(all[j].second), 0);
    members_.clear();
    for (const bool movable : {true, false})
        for (auto& [id, place] : index) {
            if ((movers.of(id) != kMaxBodies) != movable) continue;
            place = static_cast<std::uint32_t>(members_.size());
            members_.push_back({id, movers.bodies.slot(id), movable, movers.composite_of(id)});
        }
    links_.assign(joints_.size(), {});
    std::vector<std::vector<std::uint32_t>> of_body(members_.size());
    for (std::uint32_t l = 0; l < links_.size(); ++l) {
        links_[l].first = index[member_of(all[joints_[l]].first)], links_[l].second = index[member_of(all[joints_[l]].second)];
        of_body[links_[l].first].push_back(l), of_body[links_[l].second].push_back(l);
    }
    pairs_.clear(), shared_.clear();
    std::map<BlockSystem::Pair, std::size_t> place_of_pair;
    for (std::uint32_t b = 0; b < members_.size() && members_[b].movable; ++b)
        for (std::size_t i = 0; i < of_body[b].size(); ++i)
            for (std::size_t j = i + 1; j < of_body[b].size(); ++j) {
                const BlockSystem::Pair pair{of_body[b][i], of_body[b][j]};
                // Two composites may have several joints with each other.
                const auto [at, is_new] = place_of_pair.try_emplace(pair, pairs_.size());
                if (!is_new) {
                    shared_[at->second] = kBoth;
                    continue;
                }
                pairs_.push_back(pair);
                shared_.push_back(b);
            }
    const auto movable = static_cast<std::size_t>(std::ranges::count(members_, true, &Member::movable));
    // A tree has as many joints as bodies if one of them holds on to the world.
    const auto anchored =
        std::ranges::count_if(links_, [&](const Link& l) { return !members_[l.first].movable || !members_[l.second].movable; });
    has_loops_ = joints_.size() > movable - 1 + static_cast<std::size_t>(std::min<std::ptrdiff_t>(anchored, 1));
    bodies_.assign(members_.size(), {}), predicted_.assign(members_.size(), {});
    curves_.assign(links_.size(), {});
    diagonal_.resize(links_.size()), of_pairs_.resize(pairs_.size()), right_.resize(links_.size());
    placed_ = has_factors_ = false;
    see_carried(all, movers);
    return system_.lay_out(links_.size(), pairs_, kMostProducts);
}

void Assembly::see_carried(std::span<const Joint> all, const Movers& movers) {
    seen_.clear();
    if (std::ranges::all_of(members_, [](const Member& member) { return member.composite == kNoComposite; })) return;
    const auto carried = [&](BodyId body) {
        if (movers.composite_of(body) == kNoComposite) return Carried{};
        const Composites::Member& member = movers.composites.member_of(body);
        return Carried{member.offset_m, unit(member.turn)};
    };
    for (const std::uint32_t j : joints_) seen_.push_back(carried_joint(all[j], carried(all[j].first), carried(all[j].second)));
}

void Assembly::locate(const Movers& movers) {
    for (Member& member : members_) member.slot = movers.bodies.slot(member.id), member.composite = movers.composite_of(member.id);
    placed_ = false;
}

bool Assembly::rests(const Movers& movers) const {
    const Member& first = members_.front();
    if (first.composite != kNoComposite) return movers.composites.all()[first.composite].asleep != 0;
    return movers.bodies.velocity[first.slot].inverse_mass == 0;
}

void Assembly::read_composite(const Composite& composite, Body& body) {
    body.pose = {composite.motion.centre_m, composite.motion.turn};
    body.inverse_mass = 1 / composite.mass_kg;
    body.inverse_inertia = turned(composite.inverse_inertia, composite.motion.turn);
}

void Assembly::read_body(const Member& member, const Movers& movers, Body& body) {
    if (member.composite != kNoComposite) return read_composite(movers.composites.all()[member.composite], body);
    const Bodies& bodies = movers.bodies;
    body.pose = joint_pose(bodies, member.slot);
    if (!member.movable) return;
    const BodyProperties& what = bodies.properties[member.slot];
    const BodyVelocity& velocity = bodies.velocity[member.slot];
    body.inverse_mass = static_cast<double>(velocity.inverse_mass);
    if ((what.flags & kShaped) == 0) {
        const double radius = bodies.place[member.slot].radius,
                     all = static_cast<double>(velocity.inverse_surface_mass) / (radius * radius);
        body.inverse_inertia = {all, 0, 0, all, 0, all};
        return;
    }
    const BodyShapes::Kind& kind = movers.shapes.kind(movers.shapes.of(what.id));
    const Vec3 moments = kind.inertia_per_kg_m2;
    if (!kind.turns_alike) body.moments = moments, body.axes = kind.axes, body.has_other_axes = kind.has_other_axes;
    body.inverse_inertia = turned({body.inverse_mass / moments.x, 0, 0, body.inverse_mass / moments.y, 0, body.inverse_mass / moments.z},
                                  kind.principal(body.pose.turn));
}

void Assembly::place(std::span<Joint> all, const Movers& movers) {
    if (std::exchange(placed_, true)) return;
    has_factors_ = false;
    for (std::size_t b = 0; b < members_.size(); ++b) read_body(members_[b], movers, bodies_[b]);
    for (std::size_t l = 0; l < links_.size(); ++l) {
        Link& link = links_[l];
        Joint& joint = all[joints_[l]];
        const Body &first = bodies_[link.first], &second = bodies_[link.second];
        if (!seen_.empty()) seen_[l].place = joint.place;
        const Joint& as_carried = seen(all, l);
        joint.place = place_of(as_carried, first.pose, second.pose);
        link.rows = rows_of(as_carried, first.pose, second.pose);
        link.errors = errors_of(as_carried, first.pose, second.pose);
        for (std::size_t r = 0; r < kJointRows; ++r) {
            const JointRow& row = link.rows[r];
            link.responses[r] = {-first.inverse_mass * row.linear, first.inverse_inertia * row.first, second.inverse_mass * row.linear,
                                 second.inverse_inertia * row.second};
        }
        diagonal_[l].setZero();
        for (std::size_t r = 0; r < kJointRows; ++r)
            for (std::size_t c = 0; c < kJointRows; ++c) {
                const Link::Response& of = link.responses[c];
                diagonal_[l](static_cast<int>(r), static_cast<int>(c)) =
                    link.rows[r].speed(of.first_velocity, of.first_spin, of.second_velocity, of.second_spin);
            }
        const double share = has_loops_ ? kSoftnessOfLoops : kSoftnessOfTrees;
        for (int r = 0; r < 6; ++r) {
            const double own = diagonal_[l](r, r);
            link.softness[r] = own > 0 ? share * own : 0;
            // A row that this joint has not stands alone.
            diagonal_[l](r, r) = own > 0 ? own + link.softness[r] : 1;
        }
    }
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
        const Link &one = links_[pairs_[p].first], &other = links_[pairs_[p].second];
        const auto through = [&](std::uint32_t body, std::size_t r, std::size_t c) {
            const bool second = one.second == body, of_second = other.second == body;
            const JointRow& row = one.rows[r];
            const Link::Response& of = other.responses[c];
            const Vec3 velocity = of_second ? of.second_velocity : of.first_velocity, spin = of_second ? of.second_spin : of.first_spin;
            return (second ? dot(row.linear, velocity) : -dot(row.linear, velocity)) + dot(second ? row.second : row.first, spin);
        };
        for (std::size_t r = 0; r < kJointRows; ++r)
            for (std::size_t c = 0; c < kJointRows; ++c)
                of_pairs_[p](static_cast<int>(r), static_cast<int>(c)) =
                    shared_[p] == kBoth ? through(one.first, r, c) + through(one.second, r, c) : through(shared_[p], r, c);
    }
}

void Assembly::load_velocities(const Movers& movers) {
    for (std::size_t b = 0; b < members_.size(); ++b) {
        if (members_[b].composite != kNoComposite) {
            const CompositeMotion& motion = movers.composites.all()[members_[b].composite].motion;
            bodies_[b].velocity = motion.velocity_m_s, bodies_[b].spin = motion.spin_rad_s;
            continue;
        }
        const BodyVelocity& velocity = movers.bodies.velocity[members_[b].slot];
        bodies_[b].velocity = widened(velocity.linear);
        bodies_[b].spin = (1 / movers.bodies.place[members_[b].slot].radius) * widened(velocity.surface);
    }
}

void Assembly::store(const Movers& movers) const {
    for (std::size_t b = 0; b < members_.size() && members_[b].movable; ++b) {
        if (members_[b].composite != kNoComposite) {
            CompositeMotion& motion = movers.composites.all()[members_[b].composite].motion;
            motion.velocity_m_s = bodies_[b].velocity, motion.spin_rad_s = bodies_[b].spin;
            continue;
        }
        BodyVelocity& velocity = movers.bodies.velocity[members_[b].slot];
        set_single(velocity.linear, bodies_[b].velocity);
        set_single(velocity.surface, movers.bodies.place[members_[b].slot].radius * bodies_[b].spin);
    }
}

double Assembly::speed(const Link& link, std::size_t row) const {
    const Body &first = bodies_[link.first], &second = bodies_[link.second];
    return link.rows[row].speed(first.velocity, first.spin, second.velocity, second.spin);
}

void Assembly::push(Link& link, std::size_t row, double impulse) {
    link.given[row] += impulse;
    const Link::Response& of = link.responses[row];
    Body &first = bodies_[link.first], &second = bodies_[link.second];
    first.velocity = first.velocity + impulse * of.first_velocity, first.spin = first.spin + impulse * of.first_spin;
    second.velocity = second.velocity + impulse * of.second_velocity, second.spin = second.spin + impulse * of.second_spin;
}

// A row without a linear part only turns; the others push at the anchors.
void Assembly::note_impulses(std::span<Joint> all) {
    for (std::size_t l = 0; l < links_.size(); ++l) {
        Joint& joint = all[joints_[l]];
        for (std::size_t r = 0; r < kJointRows; ++r) {
            const JointRow& row = links_[l].rows[r];
            const double impulse = std::exchange(links_[l].given[r], 0);
            if (row.linear == Vec3{})
                joint.twisted = joint.twisted + impulse * row.second;
            else
                joint.pushed = joint.pushed + impulse * row.linear;
        }
    }
}

std::optional<std::uint32_t> Assembly::end_step(std::span<Joint> all, const Movers& movers, double dt_s) const {
    if (rests(movers)) return std::nullopt;
    const Bodies& bodies = movers.bodies;
    std::optional<std::uint32_t> worst;
    double most = 1;
    for (std::size_t l = 0; l < links_.size(); ++l) {
        Joint& joint = all[joints_[l]];
        const Vec3 apart = centre_of(bodies.place[bodies.slot(joint.second)]) - centre_of(bodies.place[bodies.slot(joint.first)]);
        if (const double overload = joint.end_step(apart, dt_s); overload > most) most = overload, worst = joints_[l];
    }
    return worst;
}

void Assembly::predict(const Movers& movers, double step_s) {
    for (std::size_t b = 0; b < members_.size(); ++b) {
        const Body& body = bodies_[b];
        if (members_[b].composite != kNoComposite) {
            const Composite& composite = movers.composites.all()[members_[b].composite];
            predicted_[b] = {body.pose.centre_m + step_s * body.velocity, composite.turned_freely(body.pose.turn, body.spin, step_s)};
            continue;
        }
        Vec3 spin = body.spin;
        if (body.moments != Vec3{} && spin != Vec3{}) {
            const Vec3 momentum = heavy(body.moments, body.principal(body.pose.turn), spin);
            spin = light(body.moments, body.principal(turned_by(body.pose.turn, (0.5 * step_s) * spin)), momentum);
        }
        predicted_[b] = {body.pose.centre_m + step_s * body.velocity, turned_in_step(body.pose.turn, spin, step_s)};
    }
}

// How fast its joints part: half of the energy that it would take at each row by itself, summed.
double Assembly::parting() const {
    double sum = 0;
    for (std::size_t l = 0; l < links_.size(); ++l)
        for (std::size_t r = 0; r < kDriveRow; ++r) {
            const double rate = speed(links_[l], r);
            sum += rate * rate / diagonal_[l](static_cast<int>(r), static_cast<int>(r));
        }
    return sum;
}

void Assembly::warm_start(std::span<Joint> all, const Movers& movers) {
    if (rests(movers)) return;
    place(all, movers);
    load_velocities(movers);
    const double before = has_loops_ ? parting() : 0;
    for (std::size_t l = 0; l < links_.size(); ++l)
        for (std::size_t r = 0; r < kJointRows; ++r)
            if (const double impulse = all[joints_[l]].impulses[r]; impulse != 0) push(links_[l], r, impulse);
    // Joints of a loop may press on each other with any force. As they turn, such forces of the last substep no longer cancel out, and
    // contacts would take them for blows: then the substep begins without.
    if (has_loops_ && parting() > before) {
        for (const std::uint32_t j : joints_) all[j].impulses = {};
        for (Link& link : links_) link.given = {};
        return;
    }
    store(movers);
}

void Assembly::run(Phase phase, std::span<Joint> all, const Movers& movers, double step_s) {
    if (rests(movers)) return;
    place(all, movers);
    load_velocities(movers);
    for (std::size_t l = 0; l < links_.size(); ++l) {
        Joint& joint = all[joints_[l]];
        links_[l].relaxed.setZero();
        if (!joint.moves_along()) continue;
        // A brake that slips holds on where it is.
        if (joint.drive == JointDrive::Kind::Brake)
            joint.target = std::clamp(joint.target, joint.place - joint.give(), joint.place + joint.give());
        const Curve& curve = curves_[l] = curve_of(joint, phase, step_s);
        const bool at_limit = (joint.stand == JointStand::Low && curve.least_speed > -kInfinite) ||
                              (joint.stand == JointStand::High && curve.greatest_speed < kInfinite);
        const bool driven = joint.stand == JointStand::Drive || joint.stand == JointStand::Plus || joint.stand == JointStand::Minus;
        if (!at_limit && driven != (curve.most > 0)) joint.stand = curve.most > 0 ? JointStand::Drive : JointStand::Free;
    }
    // First as if joints held along straight lines, which finds the way back also from velocities that are far off; then for where the
    // bodies will be.
    Guess guess = phase == Phase::Solve ? Guess::Straight : Guess::Now;
    for (int solution = 0; solution < kMostSolutions; ++solution) {
        set_given_impulses(all);
        solve_once(guess, all, movers, step_s);
        if (change_stands(phase, all, solution < kAllAtOnce ? links_.size() : 1)) {
            // Impulses have gone, so places are far off again.
            if (guess == Guess::Turned) guess = Guess::Straight;
            continue;
        }
        if (guess != Guess::Straight) break;
        guess = Guess::Turned;
    }
    clamp_drives(all);
    note_impulses(all);
    store(movers);
}

// If a joint has not found its place on its curve, its drive still does no more than it can.
void Assembly::clamp_drives(std::span<Joint> all) {
    for (std::size_t l = 0; l < links_.size(); ++l) {
        Joint& joint = all[joints_[l]];
        if (!joint.moves_along() || joint.stand == JointStand::Low || joint.stand == JointStand::High) continue;
        const double most = curves_[l].most, before = joint.impulses[kDriveRow], now = std::clamp(before, -most, most);
        if (now == before) continue;
        push(links_[l], kDriveRow, now - before);
        joint.impulses[kDriveRow] = now;
    }
}

// The drive's and the limits' part in a substep.
Assembly::Curve Assembly::curve_of(const Joint& joint, Phase phase, double step_s) const {
    // Where a joint counts as at its limit, rad or m: what is left after it has been stopped there.
    constexpr double kAtLimit = 1e-4;
    Curve curve{-kInfinite, kInfinite, 0, 0, 0};
    if (phase == Phase::Solve) {
        if (joint.lower > -kInfinite) curve.least_speed = (joint.lower - joint.place) / step_s;
        if (joint.upper < kInfinite) curve.greatest_speed = (joint.upper - joint.place) / step_s;
    } else {
        if (joint.stand == JointStand::Low || joint.place <= joint.lower + kAtLimit) curve.least_speed = 0;
        if (joint.stand == JointStand::High || joint.place >= joint.upper - kAtLimit) curve.greatest_speed = 0;
    }
    if (joint.is_spring()) {
        curve.softness = 1 / (step_s * (step_s * joint.stiffness + joint.damping));
        curve.free_speed = -step_s * joint.stiffness * (joint.place - joint.rest) * curve.softness;
        curve.most = kInfinite;
        curve.is_spring = true;
        return curve;
    }
    if (joint.drive == JointDrive::Kind::Coast || !(joint.strength > 0)) return curve;
    const double time_s = std::max(joint.response_s, step_s);
    curve.most = joint.strength * step_s;
    curve.softness = joint.give() / (time_s * curve.most);
    // Nothing becomes as fast, and what a drive would need for more cannot be told from what it can do.
    constexpr double kFastest = 1e6;
    const double most = joint.drive == JointDrive::Kind::Servo ? std::min(joint.servo_speed, kFastest) : kFastest;
    curve.free_speed =
        std::clamp(joint.drive == JointDrive::Kind::Motor ? joint.target : (joint.target - joint.place) / time_s, -most, most);
    return curve;
}

double Assembly::Curve::impulse_at(double speed) const { return most == 0 ? 0 : std::clamp((free_speed - speed) / softness, -most, most); }

JointStand Assembly::Curve::between_limits(double speed) const {
    if (most == 0) return JointStand::Free;
    const double impulse = impulse_at(speed);
    return impulse >= most ? JointStand::Plus : impulse <= -most ? JointStand::Minus : JointStand::Drive;
}

// Whether its last row is part of the system; a spring has done its part before the relaxation.
bool Assembly::holds(const Joint& joint, const Curve& curve, Phase phase) {
    if (joint.stand == JointStand::Drive) return phase == Phase::Solve || !curve.is_spring;
    return joint.stand == JointStand::Low || joint.stand == JointStand::High;
}

void Assembly::factor(Phase phase, std::span<const Joint> all) {
    parts_.assign(links_.size(), kInactive);
    for (std::size_t l = 0; l < links_.size(); ++l) {
        const Joint& joint = all[joints_[l]];
        if (holds(joint, curves_[l], phase)) parts_[l] = joint.stand == JointStand::Drive ? curves_[l].softness : 0;
    }
    if (std::exchange(has_factors_, true) && parts_ == factored_) return;
    factored_ = parts_;
    constexpr auto kLast = static_cast<int>(kDriveRow);
    masked_diagonal_ = diagonal_, masked_pairs_ = of_pairs_;
    for (std::size_t l = 0; l < links_.size(); ++l) {
        JointBlock& block = masked_diagonal_[l];
        if (factored_[l] != kInactive) {
            block(kLast, kLast) += factored_[l];
            continue;
        }
        block.row(kLast).setZero(), block.col(kLast).setZero();
        block(kLast, kLast) = 1;
    }
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
        if (factored_[pairs_[p].first] == kInactive) masked_pairs_[p].row(kLast).setZero();
        if (factored_[pairs_[p].second] == kInactive) masked_pairs_[p].col(kLast).setZero();
    }
    system_.set(masked_diagonal_, masked_pairs_);
    system_.factor();
}

void Assembly::set_given_impulses(std::span<Joint> all) {
    for (std::size_t l = 0; l < links_.size(); ++l) {
        Joint& joint = all[joints_[l]];
        const bool given = joint.stand == JointStand::Free || joint.stand == JointStand::Plus || joint.stand == JointStand::Minus;
        if (!joint.moves_along() || !given) continue;
        const double most = curves_[l].most;
        const double wanted = joint.stand == JointStand::Plus ? most : joint.stand == JointStand::Minus ? -most : 0;
        const double change = wanted - joint.impulses[kDriveRow];
        if (change == 0) continue;
        push(links_[l], kDriveRow, change);
        joint.impulses[kDriveRow] = wanted;
    }
}

void Assembly::solve_once(Guess guess, std::span<Joint> all, const Movers& movers, double step_s) {
    const Phase phase = guess == Guess::Now ? Phase::Relax : Phase::Solve;
    factor(phase, all);
    if (guess == Guess::Turned) predict(movers, step_s);
    for (std::size_t l = 0; l < links_.size(); ++l) {
        const Link& link = links_[l];
        const Joint& joint = all[joints_[l]];
        JointVector& right = right_[l];
        right.setZero();
        if (guess == Guess::Turned) {
            const auto errors = errors_of(seen(all, l), predicted_[link.first], predicted_[link.second]);
            for (std::size_t r = 0; r < kJointRows; ++r) right[static_cast<int>(r)] = -errors[r] / step_s;
        } else {
            const double rate = guess == Guess::Straight ? 1 / step_s : 0;
            for (std::size_t r = 0; r < kJointRows; ++r) right[static_cast<int>(r)] = -speed(link, r) - rate * link.errors[r];
        }
        for (std::size_t r = 0; r < kDriveRow; ++r) {
            const auto at = static_cast<int>(r);
            right[at] -= link.softness[at] * (phase == Phase::Solve ? joint.impulses[r] : link.relaxed[at]);
        }
        if (!joint.moves_along()) continue;
        double& along = right[static_cast<int>(kDriveRow)];
        along = 0;
        const Curve& curve = curves_[l];
        if (!holds(joint, curve, phase)) continue;
        const bool low = joint.stand == JointStand::Low, high = joint.stand == JointStand::High;
        const double wanted = low ? curve.least_speed : high ? curve.greatest_speed : curve.free_speed;
        // A limit gives way as the other rows do; in the relaxation only by what is done there, since in loops that cannot hold, what has
        // been done before may be large.
        constexpr auto kLast = static_cast<int>(kDriveRow);
        const double given = low || high ? link.softness[kLast] * (phase == Phase::Solve ? joint.impulses[kDriveRow] : link.relaxed[kLast])
                                         : curve.softness * joint.impulses[kDriveRow];
        along = wanted - speed(link, kDriveRow) - given;
    }
    system_.solve(right_);
    for (std::size_t l = 0; l < links_.size(); ++l) {
        Joint& joint = all[joints_[l]];
        for (std::size_t r = 0; r < kJointRows; ++r) {
            const double change = right_[l][static_cast<int>(r)];
            if (change == 0) continue;
            push(links_[l], r, change);
            if (phase == Phase::Solve || r == kDriveRow) joint.impulses[r] += change;
            if (phase == Phase::Relax) links_[l].relaxed[static_cast<int>(r)] += change;
        }
    }
}

// From the greatest impulse to the least: at the lower limit, all that the drive can do forward, what the speed asks for, all that it can
// do backward, at the upper limit.
JointStand Assembly::next_stand(const Curve& curve, JointStand stand, double impulse, double speed) {
    constexpr double kRounding = 1e-9;
    const double enough = kRounding * (1 + std::abs(impulse));
    if (stand == JointStand::Low)
        return impulse >= curve.impulse_at(curve.least_speed) - enough ? stand : curve.between_limits(curve.least_speed);
    if (stand == JointStand::High)
        return impulse <= curve.impulse_at(curve.greatest_speed) + enough ? stand : curve.between_limits(curve.greatest_speed);
    const double near = kRounding * (1 + std::abs(speed));
    if (speed < curve.least_speed - near) return JointStand::Low;
    if (speed > curve.greatest_speed + near) return JointStand::High;
    if (stand == JointStand::Drive)
        return impulse > curve.most + enough ? JointStand::Plus : impulse < -curve.most - enough ? JointStand::Minus : stand;
    if (stand == JointStand::Plus && curve.impulse_at(speed) < curve.most - enough) return JointStand::Drive;
    if (stand == JointStand::Minus && curve.impulse_at(speed) > -curve.most + enough) return JointStand::Drive;
    return stand;
}

bool Assembly::change_stands(Phase phase, std::span<Joint> all, std::size_t most) {
    std::size_t changed = 0;
    for (std::size_t l = 0; l < links_.size() && changed < most; ++l) {
        Joint& joint = all[joints_[l]];
        if (!joint.moves_along() || (curves_[l].is_spring && phase == Phase::Relax && joint.stand == JointStand::Drive)) continue;
        const JointStand next = next_stand(curves_[l], joint.stand, joint.impulses[kDriveRow], speed(links_[l], kDriveRow));
        changed += next != joint.stand ? 1 : 0;
        joint.stand = next;
    }
    return changed > 0;
}

std::size_t Assembly::bytes() const {
    return joints_.capacity() * sizeof(std::uint32_t) + seen_.capacity() * sizeof(Joint) + members_.capacity() * sizeof(Member) +
           bodies_.capacity() * sizeof(Body) + predicted_.capacity() * sizeof(JointPose) + links_.capacity() * sizeof(Link) +
           curves_.capacity() * sizeof(Curve) + pairs_.capacity() * sizeof(BlockSystem::Pair) + shared_.capacity() * sizeof(std::uint32_t) +
           (diagonal_.capacity() + of_pairs_.capacity() + masked_diagonal_.capacity() + masked_pairs_.capacity()) * sizeof(JointBlock) +
           right_.capacity() * sizeof(JointVector) + (factored_.capacity() + parts_.capacity()) * sizeof(double) + system_.bytes();
}

}  // namespace meld::physics
