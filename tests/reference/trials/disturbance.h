// Runs in the virtual cluster that are killed or stopped, and go on from their last snapshot on another number of processes.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "runtime/comm/transport/cluster.h"
#include "runtime/results/record/state_digest.h"
#include "tests/retraction/changes.h"
#include "tests/state/changed_share.h"
#include "tests/state/memory_shares.h"

namespace meld::reference {

// Where a run of bursts is between two ticks; the same on every process.
struct Place {
    std::size_t burst = 0;
    int patience = 0;  // Ticks that the burst may still take; 0: it has not begun.
    retraction::Changes changes;
};

class Disturbance {
  public:
    explicit Disturbance(std::uint64_t seed) : seed_(seed) {}

    // Runs body() on some processes until it is through, or is killed or stopped. Returns whether it has to run again.
    bool attempt(const std::function<void(comm::Communicator&)>& body);
    // How often that was.
    std::uint64_t stopped() const { return stopped_; }

    // ---- for the body
    // Whether it begins in the middle.
    bool goes_on() const { return from_.has_value(); }
    // Sets a new subdomain up from the snapshot, and its place.
    void load(sim::Subdomain& subdomain, Place& place) const;
    // Every process calls it. Takes a snapshot now and then, and compares it with one by what has changed; true: the run stops here.
    bool before_tick(sim::Subdomain& subdomain, const Place& place);

  private:
    struct Snapshot {
        sim::MemoryShares shares;
        Place place;
        int by = 0;  // It counts once all processes have taken it.
    };
    std::uint64_t draw(std::uint64_t below);
    // The same snapshot by changes, and its digest; and both in full.
    void compare_changes(sim::Subdomain& subdomain);

    const std::uint64_t seed_;
    std::uint64_t draws_ = 0, stopped_ = 0;
    std::optional<Snapshot> from_;
    // Of this attempt.
    std::optional<Snapshot> whole_, next_;
    std::int64_t every_ = 0, stop_after_ = 0;  // In ticks; 0: never.
    std::int64_t first_tick_ = 0;
    struct ByChanges {
        explicit ByChanges(sim::Subdomain& subdomain) : shares(subdomain) {}
        sim::ChangedShares shares;
        record::ChunkDigest digest;
    };
    std::vector<std::unique_ptr<ByChanges>> by_changes_;  // By process.
};

}  // namespace meld::reference
