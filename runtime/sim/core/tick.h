// The tick of a process: timers, events of the world, evaluation, exchange, and agreement with the other processes on what happened.
#pragma once

#include "runtime/sim/core/exchange.h"
#include "runtime/sim/core/setup/world_facts.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

// Every process calls begin, change_given and end in turn; modules act before change_given and after end.
class Tick {
  public:
    explicit Tick(Subdomain& subdomain) : subdomain_(subdomain), given_(subdomain), exchange_(subdomain) {}

    // Starts the next tick: wakes the catoms and groups whose timers are due.
    void begin();
    // Gives and takes the facts of this tick's events; after catoms have moved.
    void change_given() { given_.change(); }
    // Evaluates, commits, exchanges, and agrees with the other processes on what happened.
    const Totals& end();
    // On every process, after a tick that failed: the time is that of the last tick again, and all know whether some process stopped
    // halfway.
    void end_early();

    // On every process, after end(): the first undefined derivation of a view, if Totals::undefined says that there is one.
    eval::Failure first_undefined() const;

    // For tests: another bound on the latency of links, in ticks; with 0 there is no quarantine.
    void set_latency(u32 ticks) { subdomain_.abi_.latency = ticks; }

    // Wall-clock seconds, over the run.
    double evaluation_s() const { return evaluation_s_; }
    double exchange_s() const { return exchange_s_; }

  private:
    Totals totals_of_this_process(const eval::Failure& failure);
    // One small exchange, after which all processes know the result of all, so that they end, fail and count together.
    Totals agree(const Totals& mine);

    Subdomain& subdomain_;
    GivenFacts given_;
    Exchange exchange_;
    double evaluation_s_ = 0, exchange_s_ = 0;
};

}  // namespace meld::sim
