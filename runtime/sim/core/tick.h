// The tick of a process: timers, events of the world, evaluation, exchange, and agreement with the other processes on what happened.
#pragma once

#include "runtime/sim/core/exchange.h"
#include "runtime/sim/core/given.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

// Every process calls begin, change_given and end in turn; modules act before change_given and after end.
class Tick {
  public:
    explicit Tick(Subdomain& subdomain) : subdomain_(subdomain), given_(subdomain), exchange_(subdomain) {}

    // The next tick: catoms and groups whose time has come are woken.
    void begin();
    // What the world's events give and take in this tick; after catoms have moved.
    void change_given() { given_.change(); }
    // Evaluates, commits, exchanges, and agrees with the other processes on what happened.
    const Totals& end();
    // On every process, after a tick that failed: the time is that of the last tick again, and all know whether some are half-way.
    void end_early();

    // On every process, after end(): the first undefined derivation of a view, if Totals::undefined says that there is one.
    eval::Failure first_undefined() const;

    // For tests: another bound on the latency of links, in ticks; with 0 nothing is quarantined.
    void set_latency(u32 ticks) { subdomain_.abi_.latency = ticks; }

    // By wall clock, over the run.
    double evaluation_s() const { return evaluation_s_; }
    double exchange_s() const { return exchange_s_; }

  private:
    Totals totals_of_this_process(const eval::Failure& failure) const;
    // One small exchange, after which all processes know what all did, so that they end, fail and count together.
    Totals agree(const Totals& mine);

    Subdomain& subdomain_;
    GivenFacts given_;
    Exchange exchange_;
    double evaluation_s_ = 0, exchange_s_ = 0;
};

}  // namespace meld::sim
