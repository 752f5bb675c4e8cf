// Ends a run whose ensemble outgrows the memory, while there is still some.
#pragma once

#include <cstdint>

#include "runtime/sim/core/extension.h"

namespace meld::driver {

// Catoms that come while a run goes on, by `create` or as nodes of a graph, are no part of what it was expected to need; where each makes
// two, the machine is full within some ticks, and the system kills whom it likes. So after each tick in which many have come, as many as
// are to be expected in the next one must have room: what they need is judged by those that are there.
class RoomToGrow : public sim::SimModule {
  public:
    // So many processes share this machine.
    explicit RoomToGrow(int processes_here) : processes_here_(processes_here) {}
    Result<void> start(sim::Subdomain& subdomain) override;
    // Errors: there is no room.
    Result<void> after(sim::Subdomain& subdomain) override;
    bool leaves_facts_alone(const sim::Subdomain&) const override { return true; }
    // Nothing of a result depends on what it keeps.
    Result<void> saveable() const override { return {}; }

  private:
    Result<void> check(const sim::Subdomain& subdomain, std::uint64_t expected) const;

    int processes_here_;
    std::uint64_t start_catoms_ = 0, start_bytes_ = 0;
    std::uint64_t catoms_ = 0, came_ = 0;  // After the last tick; in it.
};

}  // namespace meld::driver
