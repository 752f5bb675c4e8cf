#include "runtime/sim/bodies/body_connections.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/base/terminal/log.h"
#include "runtime/sim/core/setup/unmatched.h"

namespace meld::sim {

namespace {

using Pair = std::pair<physics::BodyId, physics::BodyId>;

Pair pair_of(physics::BodyId one, physics::BodyId other) { return {std::min(one, other), std::max(one, other)}; }

bool is_lost(std::span<const physics::BodyId> lost, physics::BodyId id) { return std::binary_search(lost.begin(), lost.end(), id); }

}  // namespace

Result<void> BodyConnections::check(const Subdomain& subdomain) const {
    const std::vector<world::CatomGroup>& groups = world_.physics.groups;
    const auto group = std::ranges::find_if(groups, [](const world::CatomGroup& g) { return g.connected.value_or(false); });
    const bool by_world = group != groups.end();
    if (!by_world && !subdomain.program_actions.uses(ActionKind::Connect)) return {};
    const std::string who = by_world ? group->place + ": these catoms are connected" : "the program asks for `connect`";
    const std::string_view out = by_world ? "take out `connected`" : "take `connect` out of the program";
    if (!subdomain.alone())
        return fail(
            fmt::format("{}, and this run has {} processes (connected catoms move on one process only)", who, subdomain.comm.processes()),
            fmt::format("Use one process, without -n, or {}", out));
    if (world_.physics.engine != "blocks")
        return fail(fmt::format("{}, and the world has the engine \"{}\" (which connects no catoms)", who, world_.physics.engine),
                    fmt::format("Write [motion] engine = \"blocks\" in {}, or {}", world_.path, out));
    return {};
}

Result<void> BodyConnections::connect_groups(Subdomain& subdomain, physics::Scene& scene, const BodyMaker& bodies,
                                             std::span<const physics::TouchEvent> touches) const {
    std::vector<bool> connects(world_.physics.groups.size());
    for (const physics::TouchEvent& e : touches) {
        const std::optional<std::size_t> group = bodies.connected_in(e.touch.body);
        if (!group || bodies.connected_in(e.touch.other) != group) continue;
        if (auto done = scene.connect(e.touch.body, e.touch.other); !done) return done;
        connects[*group] = true;
    }
    Unmatched unmatched(subdomain.comm);
    for (std::size_t i = 0; i < connects.size(); ++i) {
        const world::CatomGroup& group = world_.physics.groups[i];
        // Of a region without catoms there is another warning.
        const bool fine = connects[i] || !group.connected.value_or(false) || !bodies.groups_met()[i];
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
    if (subdomain.world.links) return false;
    bool linked = false;
    subdomain.each_neighbour(catom, [&](Catom beside) { linked = linked || subdomain.ensemble.id(beside) == other; });
    return linked;
}

std::vector<RefusedConnection> BodyConnections::carry_out(Subdomain& subdomain, PhysicsScene& physics, BodySenses& senses,
                                                          std::span<const AskedConnection> asked) const {
    std::vector<RefusedConnection> refused;
    if (asked.empty()) return refused;
    physics::Scene& scene = *physics.scene;
    std::vector<Pair> released, connected;
    const auto order = [](std::vector<Pair>& pairs) {
        std::ranges::sort(pairs);
        pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    };
    const auto each = [&](ActionKind action, const auto& decide) {
        for (const AskedConnection& ask : asked) {
            if (ask.action != action) continue;
            const auto body = static_cast<physics::BodyId>(subdomain.ensemble.id(ask.catom));
            // Numbers beyond those of bodies belong to no catom.
            const bool exists = ask.other < physics::kMaxBodies && scene.has(static_cast<physics::BodyId>(ask.other));
            const auto other = exists ? static_cast<physics::BodyId>(ask.other) : body;
            if (const std::optional<Refusal> why = decide(ask.catom, body, other)) refused.push_back({action, ask.catom, *why});
        }
    };
    each(ActionKind::Release, [&](Catom, physics::BodyId body, physics::BodyId other) -> std::optional<Refusal> {
        if (body == other || !scene.connected(body, other)) return Refusal::NotConnected;
        released.push_back(pair_of(body, other));
        return std::nullopt;
    });
    order(released);
    each(ActionKind::Connect, [&](Catom catom, physics::BodyId body, physics::BodyId other) -> std::optional<Refusal> {
        if (std::ranges::binary_search(released, pair_of(body, other))) return Refusal::Conflict;
        if (body != other && scene.connected(body, other)) return std::nullopt;
        if (!touch(subdomain, physics, catom, body, other)) return subdomain.world.links ? Refusal::NotTouching : Refusal::NotANeighbour;
        connected.push_back(pair_of(body, other));
        return std::nullopt;
    });
    order(connected);
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
        if (!scene.has(id)) continue;
        for (const physics::BodyId other : scene.connected_to(id))
            if (!is_lost(lost, other)) senses.note_connection(subdomain, id, other, false);
    }
    std::erase_if(lasting_,
                  [&](const physics::Touch& t) { return is_lost(lost, t.body) || (!t.other_is_obstacle && is_lost(lost, t.other)); });
}

std::span<const physics::TouchEvent> BodyConnections::follow(const physics::Scene& scene, std::span<const physics::TouchEvent> events,
                                                             bool recomposed) {
    const bool parted = !world_.physics.joints.empty() && !lasting_.empty();
    if (!recomposed && !parted) return events;
    followed_.clear();
    std::vector<physics::Touch> begun;
    const std::size_t before = lasting_.size();
    const auto known = [&](const physics::Touch& touch) {
        return std::binary_search(lasting_.begin(), lasting_.begin() + static_cast<std::ptrdiff_t>(before), touch);
    };
    for (const physics::TouchEvent& e : events) {
        if (e.began && known(e.touch))
            begun.push_back(e.touch);
        else if (!e.began && scene.lasts(e.touch))
            lasting_.push_back(e.touch);
        else
            followed_.push_back(e);
    }
    std::erase_if(lasting_, [&](const physics::Touch& touch) {
        if (scene.lasts(touch)) return false;
        // The bodies have been released. If they still touch, the physics has found that out by now.
        if (!std::binary_search(begun.begin(), begun.end(), touch)) followed_.push_back({touch, false});
        return true;
    });
    std::ranges::sort(lasting_);
    std::ranges::sort(followed_);
    return followed_;
}

// If they still touch, the physics has found that out by now, on the process that looks for it.
std::span<const physics::TouchEvent> BodyConnections::follow_together(Subdomain& subdomain, std::span<const physics::TouchEvent> events) {
    parted_.clear();
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

void BodyConnections::part(std::span<const physics::ConnectionPair> joints) {
    for (const auto& [one, other] : joints) lasting_.emplace_back(one, other, false);
    std::ranges::sort(lasting_);
}

void BodyConnections::adopt(const physics::Scene& scene, std::vector<physics::TouchEvent>& touches) {
    std::erase_if(touches, [&](const physics::TouchEvent& e) { return !scene.lasts(e.touch); });
    for (const physics::TouchEvent& e : touches)
        if (!scene.connected_to(e.touch.body).empty() || !scene.connected_to(e.touch.other).empty()) lasting_.push_back(e.touch);
    std::ranges::sort(lasting_);
}

std::vector<physics::ConnectionPair> BodyConnections::lasting() const {
    std::vector<physics::ConnectionPair> pairs;
    for (const physics::Touch& touch : lasting_)
        if (!touch.other_is_obstacle) pairs.emplace_back(touch.body, touch.other);
    return pairs;
}

void BodyConnections::save(ByteWriter& out) const {
    out.write_count(lasting_.size());
    for (const physics::Touch& touch : lasting_) out.write(touch.key());
}

void BodyConnections::load(ByteReader& in) {
    for (auto left = in.read_count(sizeof(std::uint64_t)); left > 0; --left) {
        const auto key = in.read<std::uint64_t>();
        lasting_.emplace_back(static_cast<physics::BodyId>(key >> 32), static_cast<std::uint32_t>(key >> 1) & (physics::kMaxBodies - 1),
                              (key & 1) != 0);
    }
    std::ranges::sort(lasting_);
    // Several processes have saved the same.
    const auto twice = std::ranges::unique(lasting_);
    lasting_.erase(twice.begin(), twice.end());
}

Result<void> BodyConnections::check_loaded(const Subdomain& subdomain, const physics::Scene& scene) const {
    if (subdomain.alone() || scene.connection_count() == 0) return {};
    return fail(fmt::format("the run that goes on has connected catoms, and there are {} processes now (they move on one process only)",
                            subdomain.comm.processes()),
                "Use one process, without -n", ExitCode::RecordingRefused);
}

bool BodyConnections::fits(const Subdomain& subdomain, const physics::Scene& scene) const {
    return std::ranges::all_of(lasting_, [&](const physics::Touch& touch) {
        const bool one = scene.has(touch.body), both = one && (touch.other_is_obstacle || scene.has(touch.other));
        return both || (!subdomain.alone() && !one && !scene.has(touch.other));
    });
}

}  // namespace meld::sim
