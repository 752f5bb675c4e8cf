// All bursts of a trial on one clock, so that its run can be made again from any tick: some come before the last has come to rest.
#pragma once

#include "runtime/sim/simulation.h"
#include "tests/retraction/changes.h"

namespace meld::reference {

// The case with one burst, whose ticks are those of the run.
retraction::Case on_one_clock(const retraction::Case& world);
// The last tick that is of interest: some time after the last change.
std::int64_t last_tick(const retraction::Case& on_one_clock);

// Makes the changes of such a case, and keeps the run from ending before them.
class Schedule : public sim::SimModule {
  public:
    Schedule(const retraction::Case& world, const std::vector<retraction::Given>& given) : changes_(world, given) {
        changes_.begin_burst(0, 0);
    }
    Result<void> saveable() const override { return {}; }
    Result<void> step(sim::Subdomain& subdomain) override { return changes_.step(subdomain); }
    Result<void> after(sim::Subdomain& subdomain) override {
        if (!changes_.done()) subdomain.expect_event();
        return {};
    }

  private:
    retraction::Changes changes_;
};

}  // namespace meld::reference
