// Watches how the work of a run is divided among its processes, and says when to divide the ensemble anew
// (runtime/world/partition/balance_rule.h). Nothing that programs can see depends on it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "runtime/sim/core/subdomain.h"
#include "runtime/world/partition/balance_rule.h"

namespace meld::sim {

class Balance {
  public:
    // `every`: divide after this many ticks, whatever it costs; 0: when it is worth its cost.
    explicit Balance(int every) : window_(every > 0 ? every : partition::BalanceRule::kWindow), rule_(every > 0) {}

    // After a tick that went well, on every process: how to divide the ensemble before the next one, if it should be. Cost: a step for each
    // catom that was evaluated; now and then one small exchange, and where much has been lost, the work of all bricks to all processes.
    std::optional<partition::Partition> after_tick(const Subdomain& subdomain);

    const partition::BalanceRule& rule() const { return rule_; }

  private:
    void note(const Subdomain& subdomain);
    std::vector<std::uint64_t> work_of_processes(const Subdomain& subdomain);
    std::vector<partition::BrickWork> work_of_bricks(const Subdomain& subdomain) const;

    int window_;     // In ticks,
    int ticks_ = 0;  // of which so many are over.
    partition::BalanceRule rule_;
    std::uint64_t mine_ = 0;           // Evaluations of this window on this process.
    std::vector<std::uint32_t> work_;  // By slot, in this window.
};

}  // namespace meld::sim
