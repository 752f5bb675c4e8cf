// What a module with counters (ModuleInfo::counts) counts, into arrays of the runtime. What runs is the same as without them. No standard
// library.
#pragma once

#include "runtime/module/abi/geometry_abi.h"

namespace meld {

struct RuleCounts {
    u64 evaluations = 0;  // How often the body was evaluated at a catom, or for one group of the head there.
    u64 firings = 0;      // Of a linear rule: how often it was applied. A view fires once for each derivation.
    u64 derivations = 0;  // As in Eval::derivations.
    u64 messages = 0;     // Linear facts that it has sent over a link,
    u64 bits = 0;         // and their bits.
};

struct PredicateCounts {
    u64 gained = 0;     // Facts that came to hold in a tick. Linear: made at their catom. Actions: asked for.
    u64 lost = 0;       // Facts that held before a tick and no longer after it. Linear: consumed.
    u64 retracted = 0;  // Of those lost: no better value of the same group has taken the place.
    u64 waiting = 0;    // Derivations that an evaluation found in quarantine.
    u64 messages = 0;   // Changed facts, once for each link over which neighbours read them; linear facts sent.
    u64 bits = 0;
    i64 last_tick = 0;  // In which one of these has changed last; 0: never.
};

// Messages over a link, or several.
struct LinkCounts {
    u64 messages = 0;
    u64 bits = 0;
};
// What a catom has told its neighbours in one evaluation: changed facts, the same over each of its links.
struct Told {
    u32 catom = 0;
    u32 links = 0;
    LinkCounts each = {};
};

// Of one thread. The runtime makes room for an entry of `told` for each catom of a block, and empties it after the block: its own arrays by
// catom are large, and are filled fastest many catoms at a time.
struct Counters {
    RuleCounts* rules = nullptr;
    PredicateCounts* predicates = nullptr;
    Told* told = nullptr;
    u32 told_count = 0;
    // Linear facts, of all threads: [catom * kMaxPorts + port]; those over further ports together with the last. Null: no rule sends
    // anything.
    LinkCounts* links = nullptr;
    // Of the catom under evaluation, in this tick.
    LinkCounts now = {};         // Changed facts, over each link,
    u32 now_links = 0;           // if there are any; the number of links.
    LinkCounts* sent = nullptr;  // By port; as many as any catom has. Null: no rule sends anything.
    bool any_sent = false;
    // The greatest that one link has carried in one direction in one tick.
    LinkCounts greatest = {};
};

// Eval::place, for whoever asks now and then where a thread is: a rule, or one of these.
inline constexpr u32 kPlaceDecides = 0x80000000;  // + predicate: the facts of the predicate follow from what its rules have proposed.
inline constexpr u32 kPlaceOther = 0xfffffffe;    // The catom is read or written.
inline constexpr u32 kPlaceNone = 0xffffffff;     // No catom is evaluated.

}  // namespace meld
