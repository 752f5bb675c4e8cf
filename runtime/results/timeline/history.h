// Snapshots of a run in memory: what this process has of each, many of recent ticks and few of old ones.
//
// Snapshots share the chunks in which they are alike, so one of a quiet ensemble costs the time to look at it and no memory.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/sim/state/share.h"

namespace meld::timeline {

// A block that snapshots share; it goes with the last of them. The owner is shared because snapshots are dropped in an order that nobody
// knows beforehand.
using SharedBlock = std::shared_ptr<const sim::Block>;

// This process's share of a snapshot: two blocks for each chunk, its places and its state, and the rest.
struct KeptShare {
    std::vector<SharedBlock> blocks;
    SharedBlock rest;
};

// The snapshot of which every process has the share it kept. All processes hold all of it while they restore from it: catoms and ghosts may
// belong to other processes than they did.
class GatheredShares : public sim::Shares {
  public:
    // Collective. Cost: each process gets the shares of all others.
    static GatheredShares gather(const KeptShare& mine, comm::Communicator& comm);
    std::size_t count() const override { return shares_.size(); }
    std::size_t chunks(std::size_t share) const override { return shares_[share].blocks.size() / 2; }
    Result<sim::BlockView> places(std::size_t share, std::size_t chunk, sim::Block&) const override {
        return *shares_[share].blocks[2 * chunk];
    }
    Result<sim::BlockView> state(std::size_t share, std::size_t chunk, sim::Block&) const override {
        return *shares_[share].blocks[2 * chunk + 1];
    }
    Result<sim::BlockView> rest(std::size_t share, sim::Block&) const override { return *shares_[share].rest; }

  private:
    std::vector<KeptShare> shares_;
};

class History {
  public:
    // `most_bytes` is for each process; the newest snapshot is kept however large it is.
    explicit History(std::size_t most_bytes) : most_bytes_(most_bytes) {}

    using Save = std::function<Result<void>(sim::ShareSink&)>;
    // Keeps what `save` gives as the snapshot of this tick, and drops others if they are too large together: those whose neighbours in
    // time are near, compared with their age. Collective; all processes keep the same ticks. Errors: those of `save`.
    Result<void> keep(std::int64_t tick, const Save& save, comm::Communicator& comm);

    // Drops those of later ticks.
    void forget_after(std::int64_t tick);

    bool has(std::int64_t tick) const { return kept_.contains(tick); }
    // The last snapshot of this tick or an earlier one.
    std::optional<std::pair<std::int64_t, const KeptShare*>> before(std::int64_t tick) const;
    std::vector<std::int64_t> ticks() const;
    // What the snapshots of this process take.
    std::size_t bytes() const { return bytes_; }

  private:
    void drop_one(std::int64_t newest);
    void release(KeptShare& share);

    std::size_t most_bytes_;
    std::map<std::int64_t, KeptShare> kept_;
    std::size_t bytes_ = 0;
};

}  // namespace meld::timeline
