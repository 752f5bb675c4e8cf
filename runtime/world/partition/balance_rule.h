// Load balance: says when to divide a running ensemble anew, and how.
//
// Work that is unevenly divided makes processes wait for the busiest one. What they have waited since the last division, counted in
// evaluations, is what dividing anew would have saved; when that exceeds what dividing costs, the ensemble is divided. So dividing
// never costs more than has been lost by waiting: the rule by which one rents skis until their price has been paid. The
// work of a brick is how often its catoms were evaluated in the last ticks, which depends neither on processes nor on clocks, so a run is
// divided in the same way each time.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "runtime/world/partition/partition.h"

namespace meld::partition {

// How often the catoms of a brick were evaluated in the last window, and how many there are.
struct BrickWork {
    BrickKey key = 0;
    std::uint64_t work = 0;
    std::uint64_t catoms = 0;
};

// A time at which an ensemble was divided anew.
struct Division {
    std::int64_t tick = 0;    // The last tick before it.
    std::uint64_t moved = 0;  // How many catoms have got another owner.
    double imbalance = 1;     // Before it: the work of the busiest process over that of all on average.
};

class BalanceRule {
  public:
    // Ticks after which processes tell each other what they have done.
    static constexpr int kWindow = 8;
    // What it costs to give a catom to another process, or to get one, in evaluations (docs/benchmarks.md, "Load balance").
    static constexpr std::uint64_t kCostOfMove = 4;

    // `always`: divide after each window, whatever it costs.
    explicit BalanceRule(bool always) : always_(always) {}

    // A window has ended in which each process did so much.
    void end_window(std::span<const std::uint64_t> work_of_process);
    // Whether enough has been lost to look at the bricks.
    bool looks() const { return always_ || lost_ >= enough_; }
    // What a division costs the process that has most to do with it, in catoms that come or go.
    static std::uint64_t most_moved(std::span<const BrickWork> bricks, const Partition& now, const Partition& next);
    // How to divide them, if that is worth it now. `bricks`: those with catoms, sorted by key, the same on every process.
    std::optional<Partition> divide(std::span<const BrickWork> bricks, const Partition& now, std::int64_t tick);

    const std::vector<Division>& divisions() const { return divisions_; }
    // Since the last division: the work of the busiest process over that of all on average. 1: there was none.
    double imbalance() const { return all_ == 0 ? 1 : static_cast<double>(greatest_) / static_cast<double>(all_); }

  private:
    static constexpr std::uint64_t kLeastLoss = 20'000;

    bool always_;
    std::uint64_t lost_ = 0;                // Evaluations for which processes have waited since the last division.
    std::uint64_t enough_ = kLeastLoss;     // Of these, before anything is done.
    std::uint64_t greatest_ = 0, all_ = 0;  // Sums over windows since the last division: of the busiest process, of all on average.
    std::vector<Division> divisions_;
};

}  // namespace meld::partition
