#include "runtime/sim/bodies/joint_changes.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "physics/joints/assembly.h"
#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/sim/bodies/divided_bodies.h"
#include "runtime/sim/bodies/joint_spec.h"

namespace meld::sim {

namespace {

using physics::BodyId;
using Pair = physics::ConnectionPair;

// Two spheres need no search.
bool are_nearer(const physics::BodyShape& a, const physics::JointPose& a_pose, const physics::BodyShape& b,
                const physics::JointPose& b_pose, double within_m) {
    if (a.is_sphere() && b.is_sphere()) return length(b_pose.centre_m - a_pose.centre_m) < a.rounding_m + b.rounding_m + within_m;
    return physics::nearer(a, {a_pose.centre_m, a_pose.turn}, b, {b_pose.centre_m, b_pose.turn}, within_m);
}

// Whether what moves a body may have another joint. All joints and composites are on all processes, but a body that has neither may be
// elsewhere.
class Room {
  public:
    explicit Room(const physics::Scene& scene) : scene_(scene) {}

    // Both ends of a joint between these.
    bool has(BodyId body, bool fixed, BodyId other, bool other_fixed) {
        if (scene_.joints().size() + taken_.size() < physics::kMaxJointsOfBody) return true;
        const BodyId one = mover_of(body, fixed), two = mover_of(other, other_fixed);
        return one == two || (has_for(one) && has_for(two));
    }
    void take(BodyId body, bool fixed, BodyId other, bool other_fixed) {
        taken_.emplace_back(mover_of(body, fixed), mover_of(other, other_fixed));
        if (counted_) count(taken_.back());
    }

  private:
    BodyId mover_of(BodyId body, bool fixed) const {
        if (scene_.has(body)) return scene_.mover_of(body);
        return fixed ? physics::kMaxBodies : body;
    }
    void count(const Pair& movers) {
        if (movers.first != movers.second) ++joints_[movers.first], ++joints_[movers.second];
    }
    // Nobody need be counted while there are few in all.
    void count_all() {
        if (std::exchange(counted_, true)) return;
        for (const physics::Joint& joint : scene_.joints()) count({scene_.mover_of(joint.first), scene_.mover_of(joint.second)});
        for (const Pair& movers : taken_) count(movers);
    }
    bool has_for(BodyId mover) {
        count_all();
        return mover == physics::kMaxBodies || joints_[mover] < physics::kMaxJointsOfBody;
    }

    const physics::Scene& scene_;
    // The movers of joints of this tick.
    std::vector<Pair> taken_;
    std::map<BodyId, std::size_t> joints_;
    bool counted_ = false;
};

}  // namespace

bool JointChanges::asks(const Subdomain& subdomain) {
    return subdomain.program_actions.uses(ActionKind::Attach) || subdomain.program_actions.uses(ActionKind::Detach);
}

Result<void> JointChanges::check(const Subdomain& subdomain) const {
    if (!asks(subdomain) || world_.physics.engine == "blocks") return {};
    const bool attaches = subdomain.program_actions.uses(ActionKind::Attach);
    const std::string_view word = attaches ? "attach" : "detach";
    return fail(fmt::format("the program asks for `{}`, and the world has the engine \"{}\" (whose joints neither begin nor end so)", word,
                            world_.physics.engine),
                fmt::format("Write [motion] engine = \"blocks\" in {}, or take `{}` out of the program", world_.path, word));
}

// Refuses what this process can judge alone.
void JointChanges::sort_out(Subdomain& subdomain, const PhysicsScene& physics, const ContactLinks& links, std::span<const AskedJoint> asked,
                            std::vector<Wish>& wishes, std::vector<Pair>& ended, std::vector<RefusedJoint>& refused) const {
    for (const AskedJoint& ask : asked) {
        const auto body = static_cast<BodyId>(subdomain.ensemble.id(ask.catom));
        const bool may_exist = ask.other < physics::kMaxBodies && ask.other != body;
        const auto other = static_cast<BodyId>(ask.other);
        const auto refuse = [&](Refusal why) { refused.push_back({ask.action, ask.catom, why}); };
        if (ask.action == ActionKind::Detach) {
            if (may_exist && physics.scene->joined(body, other))
                ended.push_back(pair_of(body, other));
            else
                refuse(Refusal::NotJoined);
            continue;
        }
        if (ask.kind < 0 || ask.kind >= static_cast<std::int64_t>(world_.physics.joint_kinds.size())) {
            refuse(Refusal::NoSuchKind);
        } else if (!may_exist) {
            refuse(Refusal::NoSuchCatom);
        } else {
            bool linked = links.waits(pair_of(body, other));
            subdomain.each_neighbour(ask.catom, [&](Catom beside) { linked = linked || subdomain.ensemble.id(beside) == other; });
            wishes.push_back({body, other, static_cast<std::uint32_t>(ask.kind), linked ? 1u : 0u});
        }
    }
}

// Those of all processes, sorted, each once.
std::vector<JointChanges::Wish> JointChanges::gather_wishes(Subdomain& subdomain, const std::vector<Wish>& ours) {
    ByteWriter mine;
    for (const Wish& wish : ours) mine.write(wish);
    std::vector<Wish> all;
    for (const auto& from : gather_bytes(subdomain, mine))
        for (ByteReader in(from, "joints that programs ask for"); !in.done();) all.push_back(in.read<Wish>());
    std::ranges::sort(all);
    const auto twice = std::ranges::unique(all);
    all.erase(twice.begin(), twice.end());
    return all;
}

// Whoever has a catom says where it is.
JointChanges::Ends JointChanges::find_ends(Subdomain& subdomain, const physics::Scene& scene, const std::vector<Wish>& wishes) {
    std::set<BodyId> ids;
    for (const Wish& wish : wishes) ids.insert({wish.body, wish.other});
    ByteWriter mine;
    for (const BodyId id : ids) {
        const std::optional<Catom> catom = subdomain.ensemble.find(id);
        if (!catom || !subdomain.owned(*catom) || !scene.has(id)) continue;
        const double radius_m = scene.radius(id);
        mine.write(id), mine.write(static_cast<std::uint8_t>(scene.fixed(id))), mine.write(scene.pose(id)), mine.write(radius_m);
        physics::write_shape(scene.shape(id).value_or(physics::BodyShape{{}, radius_m}), mine);
    }
    Ends ends;
    for (const auto& from : gather_bytes(subdomain, mine))
        for (ByteReader in(from, "catoms that joints are to hold"); !in.done();) {
            End end{.id = in.read<BodyId>()};
            end.fixed = in.read<std::uint8_t>() != 0;
            end.pose = in.read<physics::JointPose>();
            end.radius_m = in.read<double>();
            end.shape = physics::read_shape(in);
            ends.emplace(end.id, std::move(end));
        }
    return ends;
}

ChangedJoints JointChanges::carry_out(Subdomain& subdomain, PhysicsScene& physics, const ContactLinks& links,
                                      std::span<const AskedJoint> asked, std::vector<RefusedJoint>& refused) const {
    physics::Scene& scene = *physics.scene;
    ChangedJoints changed;
    std::vector<Wish> wishes;
    sort_out(subdomain, physics, links, asked, wishes, changed.ended, refused);
    changed.ended = gather_pairs(subdomain, changed.ended);
    wishes = gather_wishes(subdomain, wishes);
    const Ends ends = wishes.empty() ? Ends() : find_ends(subdomain, scene, wishes);
    Room room(scene);
    std::map<Pair, physics::JointSpec> made;
    const auto why_not = [&](const Wish& wish) -> std::optional<Refusal> {
        const auto one = ends.find(wish.body), two = ends.find(wish.other);
        if (one == ends.end() || two == ends.end()) return Refusal::NoSuchCatom;
        const End &body = one->second, &other = two->second;
        if (scene.joined(wish.body, wish.other)) return Refusal::AlreadyJoined;
        if (made.contains(pair_of(wish.body, wish.other))) return Refusal::Conflict;
        if (body.fixed && other.fixed) return Refusal::BothFixed;
        const world::JointOptions& kind = world_.physics.joint_kinds[wish.kind];
        if (!are_nearer(body.shape, body.pose, other.shape, other.pose, 2 * world_.radius * kind.reach)) return Refusal::TooFar;
        if (!room.has(body.id, body.fixed, other.id, other.fixed)) return Refusal::TooManyJoints;
        room.take(body.id, body.fixed, other.id, other.fixed);
        const auto end = [](const End& each) { return JointEnd{each.id, each.pose, each.radius_m}; };
        made.emplace(pair_of(body.id, other.id), joint_spec_of_kind(world_, kind, end(body), end(other)));
        if (wish.linked == 0) changed.strangers.push_back(pair_of(body.id, other.id));
        return std::nullopt;
    };
    for (const Wish& wish : wishes) {
        const std::optional<Refusal> why = why_not(wish);
        const std::optional<Catom> catom = why ? subdomain.ensemble.find(wish.body) : std::nullopt;
        if (catom && subdomain.owned(*catom)) refused.push_back({ActionKind::Attach, *catom, *why});
    }
    for (const Pair& pair : changed.ended) {
        const auto done = scene.remove_joint(pair.first, pair.second);
        MELD_CHECK(done.has_value(), "catoms @{} and @{} cannot be taken apart", pair.first, pair.second);
    }
    for (const auto& [pair, spec] : made) {
        const auto done = scene.add_joint(spec, ends.at(spec.first).pose, ends.at(spec.second).pose);
        MELD_CHECK(done.has_value(), "{}", done.error().problem);
        changed.made.push_back(pair);
    }
    std::ranges::sort(changed.strangers);
    return changed;
}

}  // namespace meld::sim
