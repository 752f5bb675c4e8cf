// Looks at every tick of a run and, at its end, gathers what all processes have counted.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "runtime/engine/eval/counts.h"
#include "runtime/sim/core/extension.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::profile {

// From the start, or from an event of the world, until nothing was left to do.
struct Settling {
    enum class Cause { Start, Resumed, Event } cause = Cause::Start;
    std::int64_t tick = 0;               // Its first.
    std::optional<std::int64_t> rounds;  // Ticks, the first and the last included; none: something else came before, or the end.
};

// One tick, on all processes.
struct TickLoad {
    std::int64_t tick = 0;
    std::uint64_t evaluations = 0, derivations = 0, changes = 0, messages = 0;
};

// One process, over the run.
struct ProcessLoad {
    std::uint64_t catoms = 0;  // At the end.
    std::uint64_t evaluations = 0, derivations = 0, changes = 0, messages = 0;
    std::uint64_t bytes = 0;
};

struct PredicateLoad {
    PredicateCounts counts = {};
    std::uint64_t facts = 0;  // At the end.
    std::uint64_t bytes = 0;  // Of columns, without lists, strings and sets.
};

struct NamedCatom {
    std::uint64_t id = 0;
    eval::CatomLoad load = {};
};

// Everything, of all processes.
struct Gathered {
    bool rules_counted = false;  // The module has counters; without them nothing is known of rules, messages and links.
    std::int64_t first_tick = 0, last_tick = 0;
    std::vector<RuleCounts> rules;
    std::vector<PredicateLoad> predicates;
    std::vector<NamedCatom> busiest;         // By evaluations.
    std::vector<NamedCatom> most_messages;   // By messages.
    std::optional<NamedCatom> busiest_link;  // The catom out of which it leads.
    LinkCounts in_one_tick;                  // The most over one link, in one direction.
    std::vector<ProcessLoad> processes;
    std::vector<Settling> settlings;       // The first of them,
    std::uint64_t settlings_left_out = 0;  // and how many came after these.
    std::vector<TickLoad> ticks;           // The busiest.
};

class RunStatistics : public sim::SimModule {
  public:
    // Which catoms are busiest is known only if their evaluations are counted, which takes time in each of them.
    enum class Catoms { Counted, NotCounted };
    explicit RunStatistics(Catoms catoms) : catoms_(catoms) {}

    bool runnable() const override { return true; }
    Result<void> start(sim::Subdomain& subdomain) override;
    Result<void> resume(sim::Subdomain& subdomain) override;
    Result<void> after(sim::Subdomain& subdomain) override;
    // What was counted before a snapshot is not in it.
    Result<void> saveable() const override { return {}; }

    // On every process at the same time; what process 0 returns is of all of them.
    Gathered gather(const sim::Subdomain& subdomain) const;

  private:
    void note_settling(const sim::Subdomain& subdomain);

    Catoms catoms_;
    Settling::Cause begins_ = Settling::Cause::Start;
    std::int64_t first_tick_ = 0;
    std::vector<Settling> settlings_;
    std::uint64_t settlings_left_out_ = 0;
    std::vector<TickLoad> ticks_;
    ProcessLoad own_;
};

}  // namespace meld::profile
