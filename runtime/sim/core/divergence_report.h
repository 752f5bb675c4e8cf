// Reports what was still changing when a run should have become quiescent but did not: which predicates, at how many catoms, what one catom
// held, and the rules that make them, so that a person can find the loop.
#pragma once

#include <string>
#include <vector>

#include "runtime/module/abi/module_abi.h"

namespace meld::sim {

class Subdomain;

class Unsettled {
  public:
    // The number of ticks that are examined, the last of the run. Long enough for most delays, short enough to cost nothing.
    static constexpr i64 kTicks = 128;

    explicit Unsettled(const ModuleInfo& module);

    // Called before and after the evaluation of a tick, on every process at the same time. Facts that were given or taken from outside
    // before it do not count as changes of the catom. Cost: the facts of the catoms that are awake, twice.
    void before(Subdomain& subdomain);
    void after(Subdomain& subdomain);

    // One text for all processes, the same for any number of them; each process calls it.
    std::string describe(Subdomain& subdomain) const;

  private:
    struct Seen {
        u32 catom;
        u64 id;
    };
    // One change at the catom that is followed.
    struct Change {
        i64 tick;
        std::string text;
    };
    // For a predicate; the numbers are the same on all processes.
    struct Followed {
        u32 predicate = 0;
        i64 ticks = 0;                        // The number of ticks in which it changed,
        i64 last = 0;                         // the last of them,
        u64 most = 0;                         // and the maximum number of catoms.
        u64 id = kNobody;                     // The catom that is followed,
        i64 moved = 0;                        // and the tick of its last change.
        std::vector<std::string> facts = {};  // What it held before this tick, if it belongs to this process.
        std::vector<Change> changes = {};     // The latest changes, if it belonged to this process.
    };
    static constexpr u64 kNobody = ~u64{0};

    std::vector<std::string> facts_of(const Subdomain& subdomain, u32 predicate, u32 catom) const;
    u32 hash_of(const Subdomain& subdomain, u32 predicate, u32 catom) const;
    void note_changes(Subdomain& subdomain, Followed& f, bool changed);
    std::string changes_of(Subdomain& subdomain, const Followed& f) const;
    std::string rules_of(u32 predicate) const;
    std::string waiting(Subdomain& subdomain) const;
    std::string next_timer(Subdomain& subdomain) const;

    const ModuleInfo& module_;
    std::vector<Followed> followed_;
    std::vector<Seen> awake_;
    std::vector<u32> hashes_;  // [catom of awake_][predicate of followed_]
    u64 stride_ = 1;           // If many are awake, those whose number it divides stand for all.
    i64 looked_ = 0;           // Ticks
};

}  // namespace meld::sim
