#include "runtime/sim/bodies/body_joints.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/sim/bodies/joint_spec.h"
#include "runtime/sim/bodies/senses/body_senses.h"
#include "runtime/sim/core/setup/unmatched.h"

namespace meld::sim {

namespace {

// Catoms that a worker takes at once: whole groups of the agenda.
constexpr Catom kJointsOfJob = 1024;

// By rank: of several actions on one joint, the one with the greatest goes.
int rank_of(ActionKind action) {
    return action == ActionKind::Coast ? 0 : action == ActionKind::Motor ? 1 : action == ActionKind::Servo ? 2 : 3;
}

std::string name_of(const world::JointOptions& joint) {
    return joint.between ? fmt::format("@{} and @{}", (*joint.between)[0], (*joint.between)[1]) : fmt::format("`{}`", joint.where.text());
}

}  // namespace

void BodyJoints::start(const Subdomain& subdomain) {
    const auto sense = std::ranges::find(body_senses(), BodyQuantity::Joint, &BodySense::quantity);
    MELD_CHECK(sense != body_senses().end(), "the table has no joints");
    const std::optional<u32> base = stored(subdomain, *sense);
    if (base && subdomain.module.predicates[*base].fields[0].type == ValueType::Node) joint_ = base;
}

// Catoms of other processes that have joints.
Result<void> BodyJoints::add_ghosts(Subdomain& subdomain, PhysicsScene& physics, const BodyMaker& bodies, const Touches& touches) const {
    std::set<std::uint64_t> ids;
    for (std::size_t i = 0; i < touches.size(); ++i) {
        if (const auto& between = world_.physics.joints[i].between) ids.insert(between->begin(), between->end());
        for (const physics::TouchEvent& e : touches[i]) ids.insert({e.touch.body, std::uint64_t{e.touch.other}});
    }
    ByteWriter mine;
    for (const std::uint64_t id : ids) {
        const std::optional<Catom> catom = subdomain.ensemble.find(id);
        if (!catom || !subdomain.owned(*catom)) continue;
        mine.write(id);
        mine.write(subdomain.start_cell(*catom));
        mine.write(subdomain.ensemble.position(*catom));
    }
    const std::vector<std::vector<std::byte>> all = gather_bytes(subdomain, mine);
    for (std::size_t process = 0; process < all.size(); ++process) {
        if (process == static_cast<std::size_t>(subdomain.comm.process())) continue;
        for (ByteReader in(all[process], "catoms with joints"); !in.done();) {
            const auto id = in.read<std::uint64_t>();
            const auto cell = in.read<world::Cell>();
            const auto position = in.read<world::Vec3>();
            if (auto made = bodies.make(physics, id, cell, position, false); !made) return made;
        }
    }
    return {};
}

Result<void> BodyJoints::join(Subdomain& subdomain, PhysicsScene& physics, const BodyMaker& bodies, double max_radius_m) const {
    const std::vector<world::JointOptions>& joints = world_.physics.joints;
    physics::Scene& scene = *physics.scene;
    if (joints.empty()) return {};
    Touches touches(joints.size());
    for (std::size_t i = 0; i < joints.size(); ++i)
        if (!joints[i].between) touches[i] = touches_among(subdomain, bodies.joined_in(i), max_radius_m, physics.touch_m);
    if (!subdomain.alone())
        if (auto added = add_ghosts(subdomain, physics, bodies, touches); !added) return added;
    std::vector<bool> joins(joints.size());
    struct Joined {
        physics::BodyId first, second;
        std::size_t joint;
    };
    // By the two, the lower first: the later of two tables about the same catoms overrides the earlier one, and the scene gets its joints
    // in the order in which it keeps them.
    std::map<std::pair<physics::BodyId, physics::BodyId>, Joined> all;
    for (std::size_t i = 0; i < joints.size(); ++i) {
        const world::JointOptions& joint = joints[i];
        const auto add = [&](physics::BodyId first, physics::BodyId second) {
            joins[i] = true;
            all.insert_or_assign(std::minmax(first, second), Joined{first, second, i});
        };
        if (joint.between) {
            for (const std::uint64_t id : *joint.between)
                if (id >= physics::kMaxBodies || !scene.has(static_cast<physics::BodyId>(id)))
                    return fail(fmt::format("{}: there is no catom @{}", joint.place, id), "Name two catoms of the world");
            add(static_cast<physics::BodyId>((*joint.between)[0]), static_cast<physics::BodyId>((*joint.between)[1]));
            continue;
        }
        // Of two that are both fixed there is no joint.
        for (const physics::TouchEvent& e : touches[i])
            if (!scene.fixed(e.touch.body) || !scene.fixed(e.touch.other)) add(e.touch.body, e.touch.other);
    }
    for (const auto& [pair, joined] : all) {
        const world::JointOptions& joint = joints[joined.joint];
        const auto end = [&](physics::BodyId body) { return JointEnd{body, scene.pose(body), scene.radius(body)}; };
        if (const auto done = scene.add_joint(joint_spec(world_, joint, end(joined.first), end(joined.second))); !done) {
            const Error said = about_catoms(done.error());
            return fail(fmt::format("{}: {}", joint.place, said.problem), said.suggestion);
        }
    }
    Unmatched unmatched(subdomain.comm);
    for (std::size_t i = 0; i < joins.size(); ++i)
        unmatched.add(joins[i], [&joint = joints[i]] {
            return fmt::format("{}: no two catoms of {}, one of which can move, touch at the start, so this [[motion.joint]] joins none",
                               joint.place, name_of(joint));
        });
    unmatched.warn();
    return {};
}

void BodyJoints::add_touches(const physics::Scene& scene, std::vector<physics::TouchEvent>& touches) const {
    if (scene.joints().empty()) return;
    for (const physics::Joint& joint : scene.joints())
        touches.push_back({{std::min(joint.first, joint.second), std::max(joint.first, joint.second), false}, true});
    std::ranges::sort(touches);
}

bool BodyJoints::may_break() const {
    const auto breaks = [](const world::JointOptions& joint) { return joint.breaking_force || joint.breaking_torque; };
    return std::ranges::any_of(world_.physics.joints, breaks) || std::ranges::any_of(world_.physics.joint_kinds, breaks);
}

std::vector<world::JointLook> BodyJoints::looks(const physics::Scene& scene) const {
    using Kind = world::JointLook::Kind;
    std::vector<world::JointLook> looks;
    for (const physics::Joint& joint : scene.joints()) {
        if (!scene.counts(joint)) continue;
        const Kind kind = joint.kind == physics::JointKind::Ball     ? Kind::Ball
                          : joint.kind == physics::JointKind::Slider ? Kind::Slider
                                                                     : Kind::Hinge;
        looks.push_back(
            {kind, joint.first, joint.second, to_diameters(world_, joint.first_anchor), to_diameters(world_, joint.second_anchor)});
        if (joint.moves_along()) looks.back().axis = {joint.first_axis.x, joint.first_axis.y, joint.first_axis.z};
    }
    return looks;
}

std::vector<RefusedDrive> BodyJoints::carry_out(Subdomain& subdomain, physics::Scene& scene, std::span<const AskedDrive> asked,
                                                const DividedBodies* divided) const {
    using Pair = std::pair<physics::BodyId, physics::BodyId>;
    using Drive = std::tuple<int, double, ActionKind>;
    std::vector<RefusedDrive> refused;
    std::map<Pair, Drive> drives;
    const auto ask_for = [&](const Pair& pair, ActionKind action, double target) {
        const Drive drive{rank_of(action), target, action};
        const auto [at, is_new] = drives.try_emplace(pair, drive);
        if (!is_new) at->second = std::max(at->second, drive);
    };
    std::vector<ByteWriter> out(static_cast<std::size_t>(subdomain.comm.processes()));
    for (const AskedDrive& ask : asked) {
        const auto body = static_cast<physics::BodyId>(subdomain.ensemble.id(ask.catom));
        const bool exists = ask.other < physics::kMaxBodies && scene.has(static_cast<physics::BodyId>(ask.other));
        const auto other = exists ? static_cast<physics::BodyId>(ask.other) : body;
        if (body == other || !scene.has_motor(body, other) || !std::isfinite(ask.target)) {
            refused.push_back({ask.action, ask.catom, Refusal::NotJoined});
            continue;
        }
        const Pair pair = std::minmax(body, other);
        ask_for(pair, ask.action, ask.target);
        if (divided == nullptr) continue;
        for (const int holder : divided->holders_of(body)) {
            ByteWriter& bytes = out[static_cast<std::size_t>(holder)];
            bytes.write(pair.first);
            bytes.write(pair.second);
            bytes.write(ask.action);
            bytes.write(ask.target);
        }
    }
    if (divided != nullptr)
        for (const comm::Packet& packet : exchange_bytes(subdomain, out))
            for (ByteReader in(packet.bytes, "what drives joints"); !in.done();) {
                const auto one = in.read<physics::BodyId>(), other = in.read<physics::BodyId>();
                const auto action = in.read<ActionKind>();
                const auto target = in.read<double>();
                // A body may have other joints here.
                if (scene.joined(one, other)) ask_for({one, other}, action, target);
            }
    for (const auto& [pair, drive] : drives) {
        const ActionKind action = std::get<ActionKind>(drive);
        const bool servo = action == ActionKind::Servo;
        const double unit = servo ? unit_m(*scene.joint_kind(pair.first, pair.second)) : 1;
        const auto done = scene.drive_joint(pair.first, pair.second, {drive_of(info(action).word), unit * std::get<double>(drive)});
        MELD_CHECK(done.has_value(), "the joint of catoms @{} and @{} cannot be driven", pair.first, pair.second);
    }
    return refused;
}

std::array<Value, 3> BodyJoints::arguments_of(const Reading& reading) {
    std::array<Value, 3> arguments{};
    arguments[0].catom = reading.other;
    arguments[1].real = reading.place, arguments[2].real = reading.speed;
    return arguments;
}

std::vector<BodyJoints::Reading> BodyJoints::sensed(const Subdomain& subdomain, Catom catom) const {
    std::vector<Reading> found;
    tuple::each_fact(subdomain.module, subdomain.columns, subdomain.geometry(), *joint_, catom,
                     [&](const Value* v) { found.push_back({.other = v[0].catom, .place = v[1].real, .speed = v[2].real}); });
    return found;
}

void BodyJoints::sense(Subdomain& subdomain, const physics::Scene& scene) const {
    if (!joint_) return;
    const u64 dirty = subdomain.module.columns[subdomain.module.predicates[*joint_].column].own_dirty;
    const auto count = static_cast<Catom>(subdomain.ensemble.index_count());
    subdomain.workers.run((count + kJointsOfJob - 1) / kJointsOfJob, [&](int worker, std::size_t job) {
        const auto first = static_cast<Catom>(job) * kJointsOfJob;
        for (Catom c = first; c < std::min(count, first + kJointsOfJob); ++c)
            if (subdomain.owned(c) && sense_catom(subdomain, scene, c, worker)) subdomain.mark_shared(c, dirty);
    });
}

bool BodyJoints::sense_catom(Subdomain& subdomain, const physics::Scene& scene, Catom catom, int worker) const {
    const world::SenseOptions& enough = world_.physics.sense;
    const std::vector<Reading> last = sensed(subdomain, catom);
    std::vector<Reading> now;
    const auto body = static_cast<physics::BodyId>(subdomain.ensemble.id(catom));
    for (const physics::BodyId other : scene.joined_to(body)) {
        const auto state = scene.joint(body, other);
        MELD_CHECK(state.has_value(), "catoms @{} and @{} have no joint", body, other);
        // Zero has one sign where facts are stored.
        const Reading found{
            .other = other, .place = state->place / unit_m(*scene.joint_kind(body, other)) + 0.0, .speed = state->speed + 0.0};
        const auto former = std::ranges::find(last, found.other, &Reading::other);
        const bool differs = former == last.end() || std::abs(found.place - former->place) > enough.joint ||
                             std::abs(found.speed - former->speed) > enough.joint_speed;
        now.push_back(differs ? found : *former);
    }
    bool changed = false;
    const auto is_in = [](const std::vector<Reading>& list, const Reading& each) { return std::ranges::find(list, each) != list.end(); };
    for (const Reading& each : last)
        if (!is_in(now, each)) subdomain.take_shared(*joint_, catom, arguments_of(each).data(), worker), changed = true;
    for (const Reading& each : now)
        if (!is_in(last, each)) subdomain.give_shared(*joint_, catom, arguments_of(each).data(), worker), changed = true;
    return changed;
}

void BodyJoints::lose(Subdomain& subdomain, const physics::Scene& scene, std::span<const physics::BodyId> lost) const {
    if (!joint_) return;
    for (const physics::BodyId id : lost) {
        if (!scene.has(id)) continue;
        for (const physics::BodyId other : scene.joined_to(id)) {
            const std::optional<Catom> catom = subdomain.ensemble.find(other);
            if (!catom || !subdomain.owned(*catom)) continue;
            for (const Reading& each : sensed(subdomain, *catom))
                if (each.other == id) subdomain.take(*joint_, *catom, arguments_of(each).data());
        }
    }
}

}  // namespace meld::sim
