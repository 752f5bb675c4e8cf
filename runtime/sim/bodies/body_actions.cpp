#include "runtime/sim/bodies/body_actions.h"

#include <algorithm>
#include <cmath>

#include "physics/bodies/coils.h"
#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/engine/tuple/facts.h"

namespace meld::sim {

void BodyActions::start(const Subdomain& subdomain, const world::World& world) {
    world_ = &world;
    // A program may use the name for something else.
    const std::optional<u32> failed = tuple::find_predicate(subdomain.module, "failed", 1);
    if (!failed || subdomain.module.predicates[*failed].kind != PredicateKind::Linear ||
        subdomain.module.predicates[*failed].fields[0].type != ValueType::Int)
        return;
    const u16 base = subdomain.module.predicates[*failed].base;
    if (base != kNone16 && subdomain.module.predicates[base].column != kNone16) failed_ = base;
}

physics::Vec3 BodyActions::vector_of(const Subdomain& subdomain, const eval::Action& action) {
    const Value* v = action.arguments;
    if (subdomain.module.predicates[action.predicate].arity == 3) return {v[0].real, v[1].real, v[2].real};
    const List* list = v[0].list;
    return {tuple::item(list, 0).real, tuple::item(list, 1).real, tuple::item(list, 2).real};
}

// Actions come in the order of the catoms' numbers, so if the catom has an entry already, it is the last one.
BodyActions::AppliedWrench& BodyActions::applied_to(physics::BodyId body) {
    if (applied_.empty() || applied_.back().body != body) applied_.push_back({.body = body});
    return applied_.back();
}

Result<void> BodyActions::take(Subdomain& subdomain, PhysicsScene& physics, const DividedBodies* divided) {
    acting_ = subdomain.totals.actions > 0;
    asked_.clear(), asked_drives_.clear(), asked_joints_.clear(), asked_lamps_.clear();
    if (!acting_) return {};
    switched_.clear(), supplied_.clear();
    refuse_those_of_other_worlds(subdomain, ActionInfo::Performer::Bodies);
    for (const eval::Action& action : subdomain.actions()) {
        const ActionKind kind = subdomain.kind_of(action);
        if (info(kind).performer != ActionInfo::Performer::Bodies) continue;
        const auto body = static_cast<physics::BodyId>(subdomain.ensemble.id(action.catom));
        switch (kind) {
            case ActionKind::Magnet:
            case ActionKind::Supply:
            case ActionKind::Latch:
                if (!switch_feature(subdomain, physics, action)) report_failed(subdomain, action.catom, kind, Refusal::NoSuchFeature);
                break;
            case ActionKind::Connect:
            case ActionKind::Release:
                asked_.push_back({kind, action.catom, action.arguments[0].catom});
                break;
            case ActionKind::Motor:
            case ActionKind::Servo:
                asked_drives_.push_back({kind, action.catom, action.arguments[0].catom, action.arguments[1].real});
                break;
            case ActionKind::Brake:
            case ActionKind::Coast:
                asked_drives_.push_back({kind, action.catom, action.arguments[0].catom, 0});
                break;
            case ActionKind::Attach:
                asked_joints_.push_back({kind, action.catom, action.arguments[0].catom, action.arguments[1].integer});
                break;
            case ActionKind::Detach:
                asked_joints_.push_back({kind, action.catom, action.arguments[0].catom, 0});
                break;
            case ActionKind::Lamp:
                asked_lamps_.push_back({action.catom, action.arguments[0].real});
                break;
            case ActionKind::Force:
            case ActionKind::ForceVector: {
                AppliedWrench& wrench = applied_to(body);
                wrench.force_n = wrench.force_n + vector_of(subdomain, action);
                break;
            }
            case ActionKind::Torque:
            case ActionKind::TorqueVector: {
                AppliedWrench& wrench = applied_to(body);
                wrench.torque_nm = wrench.torque_nm + vector_of(subdomain, action);
                break;
            }
            case ActionKind::Roll:
            case ActionKind::RollVector:
                applied_to(body).angular_velocity_rad_s = vector_of(subdomain, action);
                applied_to(body).rolls = true;
                break;
            default:
                MELD_CHECK(false, "bodies do not carry out {}", info(kind).word);
        }
    }
    if (divided != nullptr) notify_holders(subdomain, *divided, true);
    return set_features(*physics.scene);
}

Result<void> BodyActions::set_features(physics::Scene& scene) const {
    for (const Switched& s : switched_)
        if (scene.has(s.body))
            if (auto done = scene.set_features(s.body, s.features.on, s.features.reversed); !done) return done;
    for (const Supplied& s : supplied_)
        if (scene.has(s.body))
            if (auto done = scene.set_supply(s.body, s.feature, s.level); !done) return done;
    return {};
}

// Processes with a ghost of a body must push and switch it in the same way, because they move their ghosts themselves.
void BodyActions::notify_holders(Subdomain& subdomain, const DividedBodies& divided, bool switches) {
    std::vector<ByteWriter> out(static_cast<std::size_t>(subdomain.comm.processes()));
    const auto notify = [&](const auto& record, Notice notice) {
        for (const int holder : divided.holders_of(record.body)) {
            out[static_cast<std::size_t>(holder)].write(notice);
            out[static_cast<std::size_t>(holder)].write(record);
        }
    };
    for (const AppliedWrench& p : applied_) notify(p, Notice::Wrench);
    if (switches) {
        for (const Switched& s : switched_) notify(s, Notice::Switched);
        for (const Supplied& s : supplied_) notify(s, Notice::Supplied);
    }
    received_.clear();
    for (const comm::Packet& packet : exchange_bytes(subdomain, out))
        for (ByteReader in(packet.bytes, "forces and switched features"); !in.done();) {
            switch (in.read<Notice>()) {
                case Notice::Wrench:
                    received_.push_back(in.read<AppliedWrench>());
                    break;
                case Notice::Switched:
                    switched_.push_back(in.read<Switched>());
                    break;
                case Notice::Supplied:
                    supplied_.push_back(in.read<Supplied>());
                    break;
            }
        }
}

void BodyActions::follow(Subdomain& subdomain, const DividedBodies& divided) {
    const auto& departed = divided.departed();
    const auto new_owner = [&](physics::BodyId body) {
        const auto at = std::lower_bound(departed.begin(), departed.end(), std::pair{body, 0});
        return at != departed.end() && at->first == body ? at->second : subdomain.comm.process();
    };
    std::vector<ByteWriter> out(static_cast<std::size_t>(subdomain.comm.processes()));
    std::erase_if(applied_, [&](const AppliedWrench& p) {
        const int owner = new_owner(p.body);
        if (owner != subdomain.comm.process()) out[static_cast<std::size_t>(owner)].write(p);
        return owner != subdomain.comm.process();
    });
    for (const comm::Packet& packet : exchange_bytes(subdomain, out))
        for (ByteReader in(packet.bytes, "forces and switched features"); !in.done();) applied_.push_back(in.read<AppliedWrench>());
    notify_holders(subdomain, divided, false);
}

// magnet(A, Feature, Polarity): 1 points out, -1 in, 0 is off; latch(A, Feature, On); supply(A, Feature, Level): what is below 0 points in.
bool BodyActions::switch_feature(Subdomain& subdomain, const PhysicsScene& physics, const eval::Action& action) {
    const i64 feature = action.arguments[0].integer;
    if (feature < 0 || feature >= static_cast<i64>(physics.features.size())) return false;
    const physics::Feature& switched = physics.features[static_cast<std::size_t>(feature)];
    const ActionKind kind = subdomain.kind_of(action);
    const bool supplies = kind == ActionKind::Supply, latches = switched.kind == physics::FeatureKind::Latch;
    // What is not a number counts as 0.
    const double level = supplies && std::isfinite(action.arguments[1].real) ? action.arguments[1].real : 0;
    const i64 value = supplies ? (level > 0) - (level < 0) : action.arguments[1].integer;
    if (supplies ? !is_supplied(switched) : latches != (kind == ActionKind::Latch)) return false;
    if (value < -1 || value > 1) return false;
    const auto body = static_cast<physics::BodyId>(subdomain.ensemble.id(action.catom));
    MELD_ASSERT(feature < 32, "feature {}", feature);
    const std::uint32_t bit = std::uint32_t{1} << feature;
    if (switched_.empty() || switched_.back().body != body) switched_.push_back({body, physics.scene->features(body)});
    physics::SwitchedFeatures& now = switched_.back().features;
    now.on = value != 0 ? now.on | bit : now.on & ~bit;
    now.reversed = value < 0 ? now.reversed | bit : now.reversed & ~bit;
    if (value != 0 && is_supplied(switched))
        supplied_.push_back({body, static_cast<std::uint32_t>(feature), supplies ? std::abs(level) : rated_supply(switched)});
    return true;
}

template <class Act>
Result<void> BodyActions::each_applied(const physics::Scene& scene, const Act& act) {
    for (const std::vector<AppliedWrench>* list : {&applied_, &received_})
        for (const AppliedWrench& p : *list)
            if (scene.has(p.body))
                if (Result<void> done = act(p); !done) return done;
    return {};
}

Result<void> BodyActions::apply(physics::Scene& scene, double step_s) {
    return each_applied(scene, [&](const AppliedWrench& p) {
        physics::Vec3 torque = p.torque_nm;
        if (p.rolls) {
            // The torque that brings it to its angular velocity within the step, if the motor is strong enough.
            const physics::Vec3 missing = p.angular_velocity_rad_s - scene.state(p.body).angular_velocity_rad_s;
            MELD_EXPECT(step_s > 0, "{} s", step_s);
            physics::Vec3 motor = (scene.moment_of_inertia(p.body) / step_s) * missing;
            const double strength = length(motor), most = world_->physics.roll_torque;
            if (strength > most) motor = (most / strength) * motor;
            torque = torque + motor;
        }
        return scene.set_wrench(p.body, p.force_n, torque);
    });
}

Result<void> BodyActions::release(physics::Scene& scene) {
    auto done = each_applied(scene, [&](const AppliedWrench& p) { return scene.set_wrench(p.body, {}, {}); });
    applied_.clear();
    received_.clear();
    return done;
}

void BodyActions::report_failed(Subdomain& subdomain, Catom catom, ActionKind action, Refusal why) {
    subdomain.refuse(action, why);
    if (!failed_) return;
    Value value{};
    value.integer = info(action).failure;
    subdomain.give(*failed_, catom, &value);
    subdomain.note_change();
}

}  // namespace meld::sim
