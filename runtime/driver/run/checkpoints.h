// When a run writes checkpoints, and what it says of them; how it goes on from one.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/driver/run/configuration_agreement.h"
#include "runtime/driver/setup/options.h"
#include "runtime/results/record/state_digest.h"
#include "runtime/sim/simulation.h"
#include "runtime/sim/state/changed_chunks.h"
#include "runtime/sim/state/checkpoint_folder.h"

namespace meld::driver {

// One of the two.
struct Interval {
    double seconds = 0;
    std::int64_t ticks = 0;
};

// "10min", "30 s" or "1000ticks". Errors: anything else, or nothing at all.
Result<Interval> parse_interval(std::string_view text);

// The run as its checkpoints know it.
sim::RunIdentity identity(const RunOptions& options, const std::vector<Claim>& claims, const world::World& world);

// Every process has one and calls all of it at the same time.
class Checkpoints {
  public:
    Checkpoints(sim::Simulation& simulation, sim::CheckpointFolder folder, sim::RunIdentity run, Interval every)
        : simulation_(simulation), folder_(std::move(folder)), run_(std::move(run)), every_(every) {}

    // Sets the simulation up from the newest checkpoint. Errors: there is none that is whole; it is of another run.
    Result<void> resume(const sim::Registry& registry);
    // Writes one if it is time. One that cannot be written is a warning: the run goes on.
    void after_tick();
    // Before the run ends, in whatever way, so that it can go on from there.
    void at_end();
    // "checkpoint of tick 400"; empty before the first.
    std::string status() const;
    // Writes one now.
    void write();

  private:
    sim::Simulation& simulation_;
    sim::CheckpointFolder folder_;
    sim::RunIdentity run_;
    Interval every_;
    // Where checkpoints hold what has changed, on lattices; from the first one on.
    std::optional<sim::ChangedChunks> changed_;
    record::ChunkDigest digest_;
    std::chrono::steady_clock::time_point last_try_ = std::chrono::steady_clock::now();
};

}  // namespace meld::driver
