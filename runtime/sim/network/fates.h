// What becomes of what catoms send each other: the terms of each link, how long it takes, what is lost or held up, and which links go down
// because something was lost over them for good.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/module/abi/module_abi.h"
#include "runtime/sim/catoms/membership.h"
#include "runtime/sim/network/readers.h"
#include "runtime/world/description/network.h"

namespace meld::sim {

class Fates {
  public:
    Fates(const world::World& world, Membership& members) : world_(world), members_(members) {}

    // Which terms a link has in one direction: of the network's parts, from 1, and after them its single links; 0: none of these.
    u32 part_between(Catom from, Catom to) const;
    const world::LinkTerms& terms(u32 part) const;
    // Of what is sent in a tick over a link with these terms.
    world::Fate of(u32 part, Catom from, Catom to, i64 now) const;
    // Whether all links have the same terms.
    bool same_terms() const { return world_.network.parts.empty() && world_.network.singles.empty(); }
    // The same of several links of a catom.
    void of(Catom from, std::span<const Reader> to, i64 now, std::span<world::Fate> fates) const;
    // Whether what is sent takes some ticks, and nothing else happens to it: all links have the same terms, nothing is lost, and every
    // catom acts in every tick.
    bool only_delays() const { return same_terms() && world_.network.kind == world::NetworkKind::Latency && world_.clock.synchronous(); }
    // These ticks.
    void delays(Catom from, std::span<const Reader> to, i64 now, std::span<u32> ticks) const;
    // The first tick from this one on in which a catom acts.
    i64 acts_from(Catom catom, i64 tick) {
        if (world_.clock.synchronous() || world_.clock.gives_turns()) return tick;
        if (const auto known = known_turn(catom, tick)) return *known;
        return find_turn(catom, tick);
    }
    // Whether it acts in this tick. Called by all workers, while nobody calls acts_from().
    bool acts(i64 tick, Catom catom) const {
        if (const auto known = known_turn(catom, tick)) return *known == tick;
        return world_.clock.acts(world_.seed, members_.ensemble.id(catom), tick);
    }
    // To be called every 2^31 ticks or more often: what acts_from() has found is forgotten.
    void forget_turns() { turns_.clear(); }
    // The same of a catom whose links have changed: another one may have its index now.
    void forget_turn(Catom catom) {
        if (catom < turns_.size()) turns_[catom] = {};
    }
    std::size_t bytes() const { return turns_.capacity() * sizeof(Turn); }
    // The first tick in which the jams of this one let something through; `now`, if none is about this link.
    i64 jammed_until(i64 now, Catom from, Catom to) const { return world_.longest_jam == 0 ? now : end_of_jam(now, from, to); }

    // Something was lost for good, which both ends know from this tick on.
    void lose(i64 tick, Catom from, Catom to);
    // If that is the fate of what one catom sends to another, which another process carries.
    void note_loss(i64 now, Catom from, Catom to);
    // Links over which something was lost until this tick are removed; both ends are marked.
    void take_down(i64 now, const std::function<void(Catom)>& mark);
    // Between these catoms there is no link, or another one.
    void forget_loss(u64 a, u64 b);
    bool any_lost() const { return !down_.empty(); }

    void save(ByteWriter& out) const;
    void load(ByteReader& in);

  private:
    // That a catom acts `wait` ticks after this one, modulo 2^32, and not before.
    struct Turn {
        u32 from = 0;
        u32 wait = kNone32;
    };
    std::optional<i64> known_turn(Catom catom, i64 tick) const {
        if (catom >= turns_.size() || turns_[catom].wait == kNone32) return std::nullopt;
        const u32 since = static_cast<u32>(tick) - turns_[catom].from, wait = turns_[catom].wait;
        return since <= wait ? std::optional(tick + (wait - since)) : std::nullopt;
    }
    i64 find_turn(Catom catom, i64 tick);
    i64 end_of_jam(i64 now, Catom from, Catom to) const;

    // From this tick on there is no link between these catoms.
    struct Down {
        i64 tick;
        u64 from, to;
    };

    const world::World& world_;
    Membership& members_;
    std::vector<Down> down_;
    std::vector<Turn> turns_;  // By catom: what was found last. Many messages come to a catom before it acts.
};

}  // namespace meld::sim
