#include "runtime/sim/bodies/body_connections.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/base/terminal/log.h"
#include "runtime/sim/core/setup/unmatched.h"

namespace meld::sim {

namespace {

using Pair = std::pair<physics::BodyId, physics::BodyId>;

physics::Touch touch_with(std::uint64_t key) {
    return {static_cast<physics::BodyId>(key >> 32), static_cast<std::uint32_t>(key >> 1) & (physics::kMaxBodies - 1), (key & 1) != 0};
}

// One whose parts are connected, of robots that there are.
const world::Assembly& connecting_assembly(const world::Robots& robots) {
    const auto connects = [&](const world::RobotGroup& group) { return !robots.assemblies()[group.assembly].connections.empty(); };
    return robots.assemblies()[std::ranges::find_if(robots.groups(), connects)->assembly];
}

// Of two parts of one robot: whether its assembly says so.
bool are_connected_parts(const world::Robots& robots, physics::BodyId one, physics::BodyId other) {
    const std::optional<world::RobotPart> a = robots.of(one), b = robots.of(other);
    return a && b && robots.assemblies()[a->assembly].connects(a->part, b->part);
}

bool is_lost(std::span<const physics::BodyId> lost, physics::BodyId id) { return std::binary_search(lost.begin(), lost.end(), id); }

}  // namespace

bool BodyConnections::by_world() const {
    return std::ranges::any_of(world_.physics.groups, [](const world::CatomGroup& g) { return g.connected.value_or(false); }) ||
           (world_.robots && world_.robots->connects());
}

bool BodyConnections::are_beside_joints(const Subdomain& subdomain, const physics::Scene& scene) const {
    const bool connects = by_world() || subdomain.program_actions.uses(ActionKind::Connect) || scene.connection_count() > 0;
    return (connects || JointChanges::asks(subdomain)) && world_.physics.has_joints();
}

Result<void> BodyConnections::check(const Subdomain& subdomain) const {
    const std::vector<world::CatomGroup>& groups = world_.physics.groups;
    const auto group = std::ranges::find_if(groups, [](const world::CatomGroup& g) { return g.connected.value_or(false); });
    const bool by_group = group != groups.end(), by_robots = !by_group && by_world();
    if (!by_world() && !subdomain.program_actions.uses(ActionKind::Connect)) return {};
    const std::string who = by_group    ? group->place + ": these catoms are connected"
                            : by_robots ? connecting_assembly(*world_.robots).place + ": its parts are connected"
                                        : "the program asks for `connect`";
    const std::string_view out = by_group    ? "take out `connected`"
                                 : by_robots ? "take out `connections`"
                                             : "take `connect` out of the program";
    if (world_.physics.engine != "blocks")
        return fail(fmt::format("{}, and the world has the engine \"{}\" (which connects no catoms)", who, world_.physics.engine),
                    fmt::format("Write [motion] engine = \"blocks\" in {}, or {}", world_.path, out));
    return {};
}

Result<void> BodyConnections::connect_groups(Subdomain& subdomain, physics::Scene& scene, const BodyMaker& bodies,
                                             std::span<const physics::TouchEvent> touches) const {
    // Each process knows the groups of its catoms.
    std::map<physics::BodyId, std::uint64_t> mine, groups;
    for (const physics::TouchEvent& e : touches)
        for (const physics::BodyId body : {e.touch.body, physics::BodyId{e.touch.other}})
            if (const std::optional<std::size_t> group = bodies.connected_in(body)) mine.emplace(body, *group);
    ByteWriter out;
    for (std::size_t i = 0; i < world_.physics.groups.size(); ++i) out.write(std::uint8_t{bodies.groups_met()[i]});
    for (const auto& [body, group] : mine) out.write(body), out.write(group);
    std::vector<bool> met(world_.physics.groups.size()), connects(met.size());
    for (const auto& from : gather_bytes(subdomain, out)) {
        ByteReader in(from, "catoms that are connected at the start");
        for (std::size_t i = 0; i < met.size(); ++i) met[i] = in.read<std::uint8_t>() != 0 || met[i];
        while (!in.done()) {
            const auto body = in.read<physics::BodyId>();
            groups[body] = in.read<std::uint64_t>();
        }
    }
    for (const physics::TouchEvent& e : touches) {
        const auto one = groups.find(e.touch.body), other = groups.find(e.touch.other);
        if (one == groups.end() || other == groups.end() || one->second != other->second) continue;
        const bool of_robot = one->second >= connects.size();
        if (of_robot && !are_connected_parts(*world_.robots, e.touch.body, e.touch.other)) continue;
        if (auto done = scene.connect(e.touch.body, e.touch.other); !done) return done;
        if (!of_robot) connects[one->second] = true;
    }
    Unmatched unmatched(subdomain.comm);
    for (std::size_t i = 0; i < connects.size(); ++i) {
        const world::CatomGroup& group = world_.physics.groups[i];
        // Of a region without catoms there is another warning.
        const bool fine = connects[i] || !group.connected.value_or(false) || !met[i];
        unmatched.add(fine, [&] {
            return fmt::format("{}: no two catoms of `{}` touch at the start, so none are connected", group.place, group.where.text());
        });
    }
    unmatched.warn();
    return {};
}

void BodyConnections::sense_all(Subdomain& subdomain, const physics::Scene& scene, BodySenses& senses) const {
    if (!senses.senses_connections()) return;
    for (const auto& [one, other] : scene.connections()) senses.note_connection(subdomain, one, other, true);
}

// In a world whose neighbours are those within a range, they need not touch.
bool BodyConnections::touch(const Subdomain& subdomain, const PhysicsScene& physics, Catom catom, physics::BodyId body,
                            physics::BodyId other) {
    const physics::Scene& scene = *physics.scene;
    if (body == other || !scene.has(other)) return false;
    if (scene.nearer(body, other, physics.touch_m)) return true;
    // Those whom a joint holds are neighbours wherever they are.
    if (subdomain.world.links || scene.joined(body, other)) return false;
    bool linked = false;
    subdomain.each_neighbour(catom, [&](Catom beside) { linked = linked || subdomain.ensemble.id(beside) == other; });
    return linked;
}

bool BodyConnections::may_break() const {
    const world::PhysicsOptions& options = world_.physics;
    return options.breaking_force || options.breaking_torque ||
           std::ranges::any_of(options.groups, [](const world::CatomGroup& g) { return g.breaking_force || g.breaking_torque; });
}

std::vector<RefusedConnection> BodyConnections::carry_out(Subdomain& subdomain, PhysicsScene& physics, BodySenses& senses,
                                                          std::span<const AskedConnection> asked) const {
    std::vector<RefusedConnection> refused;
    if (subdomain.alone() && asked.empty()) return refused;
    physics::Scene& scene = *physics.scene;
    std::vector<Pair> released, connected;
    const auto order = [](std::vector<Pair>& pairs) {
        std::ranges::sort(pairs);
        pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    };
    // Those who ask for a connection, and why they get none unless the other asks for a release.
    struct Wish {
        Catom catom;
        Pair pair;
        std::optional<Refusal> why;
    };
    std::vector<Wish> wishes;
    for (const AskedConnection& ask : asked) {
        const auto body = static_cast<physics::BodyId>(subdomain.ensemble.id(ask.catom));
        // Numbers beyond those of bodies belong to no catom. Bodies that are far away may be unknown to this process.
        const bool exists = ask.other < physics::kMaxBodies && scene.has(static_cast<physics::BodyId>(ask.other));
        const auto other = exists ? static_cast<physics::BodyId>(ask.other) : body;
        const Pair pair = pair_of(body, other);
        const bool holds = body != other && scene.connected(body, other);
        if (ask.action == ActionKind::Connect) {
            const bool fine = holds || touch(subdomain, physics, ask.catom, body, other);
            const bool linked_apart = subdomain.world.links || (exists && scene.joined(body, other));
            const Refusal why = linked_apart ? Refusal::NotTouching : Refusal::NotANeighbour;
            wishes.push_back({ask.catom, pair, fine ? std::nullopt : std::optional(why)});
            if (fine && !holds) connected.push_back(pair);
        } else if (holds) {
            released.push_back(pair);
        } else {
            refused.push_back({ask.action, ask.catom, Refusal::NotConnected});
        }
    }
    if (!subdomain.alone()) {
        ByteWriter mine;
        for (const std::vector<Pair>* pairs : {&released, &connected}) {
            mine.write_count(pairs->size());
            for (const auto& [one, other] : *pairs) mine.write(one), mine.write(other);
        }
        released.clear(), connected.clear();
        for (const auto& from : gather_bytes(subdomain, mine)) {
            ByteReader in(from, "connections that catoms ask for");
            for (std::vector<Pair>* pairs : {&released, &connected})
                for (auto left = in.read_count(2 * sizeof(physics::BodyId)); left > 0; --left) {
                    const auto one = in.read<physics::BodyId>();
                    pairs->emplace_back(one, in.read<physics::BodyId>());
                }
        }
    }
    order(released), order(connected);
    for (const Wish& wish : wishes) {
        const bool conflicts = std::ranges::binary_search(released, wish.pair);
        if (conflicts || wish.why) refused.push_back({ActionKind::Connect, wish.catom, conflicts ? Refusal::Conflict : *wish.why});
    }
    std::erase_if(connected, [&](const Pair& pair) { return std::ranges::binary_search(released, pair); });
    const auto change = [&](const Pair& pair, bool holds) {
        const auto done = holds ? scene.connect(pair.first, pair.second) : scene.release(pair.first, pair.second);
        MELD_CHECK(done.has_value(), "catoms @{} and @{} cannot be connected or released", pair.first, pair.second);
        senses.note_connection(subdomain, pair.first, pair.second, holds);
    };
    for (const Pair& pair : released) change(pair, false);
    for (const Pair& pair : connected) change(pair, true);
    return refused;
}

void BodyConnections::lose(Subdomain& subdomain, const physics::Scene& scene, BodySenses& senses, std::span<const physics::BodyId> lost) {
    MELD_EXPECT(std::ranges::is_sorted(lost), "{} bodies are not in order", lost.size());
    for (const physics::BodyId id : lost) {
        for (const physics::BodyId other : scene.connected_to(id))
            if (!is_lost(lost, other)) senses.note_connection(subdomain, id, other, false);
    }
    std::erase_if(lasting_,
                  [&](const physics::Touch& t) { return is_lost(lost, t.body) || (!t.other_is_obstacle && is_lost(lost, t.other)); });
}

std::span<const physics::TouchEvent> BodyConnections::follow(const physics::Scene& scene, std::span<const physics::TouchEvent> events,
                                                             bool recomposed) {
    const bool parted = world_.physics.has_joints() && !lasting_.empty();
    if (!recomposed && !parted && made_.empty()) return events;
    followed_.clear();
    std::vector<physics::Touch> begun;
    const std::size_t before = lasting_.size();
    const auto known = [&](const physics::Touch& touch) {
        return std::binary_search(lasting_.begin(), lasting_.begin() + static_cast<std::ptrdiff_t>(before), touch);
    };
    for (const physics::TouchEvent& e : events) {
        if (e.began && known(e.touch))
            begun.push_back(e.touch);
        else if (!e.began && begins(e.touch))
            continue;
        else if (!e.began && scene.lasts(e.touch))
            lasting_.push_back(e.touch);
        else
            followed_.push_back(e);
    }
    std::erase_if(lasting_, [&](const physics::Touch& touch) {
        if (!is_over(scene, touch)) return false;
        // The bodies have been released. If they still touch, the physics has found that out by now.
        if (!std::binary_search(begun.begin(), begun.end(), touch)) followed_.push_back({touch, false});
        return true;
    });
    for (const physics::Touch& touch : strangers_) followed_.push_back({touch, true});
    made_.clear(), strangers_.clear(), apart_.clear();
    std::ranges::sort(lasting_);
    std::ranges::sort(followed_);
    return followed_;
}

// A joint ends the touch of its catoms for the physics alone.
bool BodyConnections::begins(const physics::Touch& touch) const { return std::ranges::binary_search(made_, touch); }

bool BodyConnections::is_over(const physics::Scene& scene, const physics::Touch& touch) const {
    return !scene.lasts(touch) || std::ranges::binary_search(apart_, touch);
}

// If they still touch, the physics has found that out by now, on the process that looks for it.
std::span<const physics::TouchEvent> BodyConnections::follow_joints(Subdomain& subdomain, std::span<const physics::TouchEvent> events) {
    if (lasting_.empty()) return events;
    followed_.clear();
    ByteWriter mine;
    for (const physics::TouchEvent& e : events) {
        if (e.began && std::ranges::binary_search(lasting_, e.touch))
            mine.write(e.touch.key());
        else
            followed_.push_back(e);
    }
    std::vector<std::uint64_t> begun;
    for (const auto& from : gather_bytes(subdomain, mine))
        for (ByteReader in(from, "touches behind joints"); !in.done();) begun.push_back(in.read<std::uint64_t>());
    std::ranges::sort(begun);
    for (const physics::Touch& touch : lasting_)
        if (!std::ranges::binary_search(begun, touch.key())) parted_.push_back({touch, false});
    lasting_.clear();
    return followed_;
}

// A touch may have ended on a process that has its catoms no longer, so all learn what has ended; who has the first of the two knows
// whether it lasts.
std::span<const physics::TouchEvent> BodyConnections::follow_together(Subdomain& subdomain, const physics::Scene& scene,
                                                                      std::span<const physics::TouchEvent> events, bool recomposed) {
    parted_.clear();
    const bool broke = std::exchange(joints_broke_, false) && !lasting_.empty();
    if (world_.physics.has_joints() && !scene.has_all_joined()) return follow_joints(subdomain, events);
    if (!recomposed && !(broke && scene.has_all_joined()) && made_.empty()) return events;
    followed_.clear();
    using Touches = std::vector<physics::Touch>;
    const auto gather = [&](const Touches& mine) {
        ByteWriter out;
        for (const physics::Touch& touch : mine) out.write(touch.key());
        Touches all;
        for (const auto& from : gather_bytes(subdomain, out))
            for (ByteReader in(from, "touches of connected catoms"); !in.done();) all.push_back(touch_with(in.read<std::uint64_t>()));
        std::ranges::sort(all);
        return all;
    };
    Touches mine_begun, mine_ended, mine_over;
    for (const physics::TouchEvent& e : events) {
        if (!e.began && begins(e.touch))
            continue;
        else if (!e.began)
            mine_ended.push_back(e.touch);
        else if (std::ranges::binary_search(lasting_, e.touch))
            mine_begun.push_back(e.touch);
        else
            followed_.push_back(e);
    }
    const Touches begun = gather(mine_begun), ended = gather(mine_ended);
    const auto owned = [&](physics::BodyId body) {
        const std::optional<Catom> catom = subdomain.ensemble.find(body);
        return catom && subdomain.owned(*catom);
    };
    for (const Touches* touches : {&ended, const_cast<const Touches*>(&lasting_)})
        for (const physics::Touch& touch : *touches)
            if (owned(touch.body) && is_over(scene, touch)) mine_over.push_back(touch);
    const Touches over = gather(mine_over);
    const auto is_over_for_all = [&](const physics::Touch& touch) { return std::ranges::binary_search(over, touch); };
    const auto end = [&](const physics::Touch& touch) {
        if (!touch.other_is_obstacle)
            parted_.push_back({touch, false});
        else if (owned(touch.body))
            followed_.push_back({touch, false});
    };
    std::erase_if(lasting_, [&](const physics::Touch& touch) {
        if (!is_over_for_all(touch)) return false;
        // If they still touch, the physics has found that out by now.
        if (!std::ranges::binary_search(begun, touch)) end(touch);
        return true;
    });
    for (const physics::Touch& touch : ended) {
        if (is_over_for_all(touch))
            end(touch);
        else
            lasting_.push_back(touch);
    }
    for (const physics::Touch& touch : strangers_)
        if (owned(touch.body)) followed_.push_back({touch, true});
    made_.clear(), strangers_.clear(), apart_.clear();
    std::ranges::sort(lasting_), std::ranges::sort(followed_), std::ranges::sort(parted_);
    return followed_;
}

void BodyConnections::part(std::span<const physics::ConnectionPair> joints) {
    for (const auto& [one, other] : joints) lasting_.emplace_back(one, other, false);
    std::ranges::sort(lasting_);
    joints_broke_ = true;
}

void BodyConnections::change_joints(const PhysicsScene& physics, const ChangedJoints& changed) {
    const auto touches_of = [](std::span<const Pair> pairs) {
        std::vector<physics::Touch> touches;
        for (const auto& [one, other] : pairs) touches.emplace_back(one, other, false);
        return touches;
    };
    made_ = touches_of(changed.made), strangers_ = touches_of(changed.strangers);
    // They are neighbours as long as they have the joint, whatever they are connected to.
    std::erase_if(lasting_, [&](const physics::Touch& touch) { return begins(touch); });
    if (changed.ended.empty()) return;
    for (const auto& [one, other] : changed.ended)
        if (!physics.scene->nearer(one, other, physics.touch_m)) apart_.emplace_back(one, other, false);
    part(changed.ended);
}

void BodyConnections::adopt(Subdomain& subdomain, const physics::Scene& scene, std::vector<physics::TouchEvent>& touches) {
    // Also by joints that broke in this step: part() follows.
    const auto joined = [&](const physics::Touch& t) {
        if (t.other_is_obstacle) return false;
        return scene.joined(t.body, t.other) || std::ranges::binary_search(scene.broken_joints(), Pair(t.body, t.other));
    };
    std::erase_if(touches, [&](const physics::TouchEvent& e) { return !scene.lasts(e.touch) && !joined(e.touch); });
    ByteWriter mine;
    for (const physics::TouchEvent& e : touches)
        if (!joined(e.touch) && (!scene.connected_to(e.touch.body).empty() || !scene.connected_to(e.touch.other).empty()))
            mine.write(e.touch.key());
    for (const auto& from : gather_bytes(subdomain, mine))
        for (ByteReader in(from, "touches of connected catoms"); !in.done();) lasting_.push_back(touch_with(in.read<std::uint64_t>()));
    std::ranges::sort(lasting_);
}

std::vector<physics::ConnectionPair> BodyConnections::lasting() const {
    std::vector<physics::ConnectionPair> pairs;
    if (!world_.physics.has_joints()) return pairs;
    for (const physics::Touch& touch : lasting_)
        if (!touch.other_is_obstacle) pairs.emplace_back(touch.body, touch.other);
    return pairs;
}

void BodyConnections::save(ByteWriter& out) const {
    out.write_count(lasting_.size());
    for (const physics::Touch& touch : lasting_) out.write(touch.key());
}

void BodyConnections::load(ByteReader& in) {
    for (auto left = in.read_count(sizeof(std::uint64_t)); left > 0; --left) lasting_.push_back(touch_with(in.read<std::uint64_t>()));
    std::ranges::sort(lasting_);
    // Several processes have saved the same.
    const auto twice = std::ranges::unique(lasting_);
    lasting_.erase(twice.begin(), twice.end());
}

bool BodyConnections::fits(const Subdomain& subdomain, const physics::Scene& scene) const {
    const bool joints = world_.physics.has_joints();
    return std::ranges::all_of(lasting_, [&](const physics::Touch& touch) {
        const bool one = scene.has(touch.body), both = one && (touch.other_is_obstacle || scene.has(touch.other));
        if (both || subdomain.alone()) return both;
        if (joints) return !one && !scene.has(touch.other);
        const std::optional<Catom> catom = subdomain.ensemble.find(touch.body);
        return !catom || !subdomain.owned(*catom);
    });
}

}  // namespace meld::sim
