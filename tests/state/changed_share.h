// Snapshots of one process by what has changed since the one before, each beside a whole one, which it must be.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <utility>

#include "memory_shares.h"
#include "runtime/sim/state/changed_chunks.h"
#include "runtime/sim/state/share.h"

namespace meld::sim {

class ChangedShares {
  public:
    // Chunks of one catom each, so that nothing hides behind a change beside it.
    explicit ChangedShares(Subdomain& subdomain, std::size_t catoms = 1) : changed_(subdomain, catoms) {}

    using Save = std::function<Result<void>(ShareSink&, ChangedChunks*)>;
    // Between two ticks. Returns what is wrong with the one by changes; empty: nothing.
    std::string take(const Save& save) {
        changed_.look();
        Share by_changes(changed_.catoms(), &last_), whole(changed_.catoms(), nullptr);
        if (const auto done = save(by_changes, &changed_); !done) return done.error().message();
        if (const auto done = save(whole, nullptr); !done) return done.error().message();
        changed_.saved();
        taken_ += by_changes.taken;
        made_ += by_changes.chunks.size() - by_changes.taken;
        last_ = std::move(by_changes.chunks);
        for (const auto& [number, chunk] : whole.chunks) {
            const auto mine = last_.find(number);
            if (mine == last_.end()) return "there is no chunk " + std::to_string(number);
            if (mine->second.places != chunk.places) return "the places of chunk " + std::to_string(number) + " have changed unseen";
            if (mine->second.state != chunk.state) return "the state of chunk " + std::to_string(number) + " has changed unseen";
        }
        return last_.size() == whole.chunks.size() && by_changes.the_rest == whole.the_rest ? "" : "there are chunks too many";
    }
    // After look() of the last one: for digests.
    const ChangedChunks& changed() const { return changed_; }
    // Chunks of all snapshots that were as before, and those that were made.
    std::size_t taken() const { return taken_; }
    std::size_t made() const { return made_; }

  private:
    using Chunks = std::map<std::size_t, MemoryShare::Kept>;
    struct Share : ShareSink {
        Share(std::size_t catoms_of_a_chunk, const Chunks* those_before) : catoms(catoms_of_a_chunk), before(those_before) {}
        std::size_t chunk_catoms() const override { return catoms; }
        Result<void> chunk(const Chunk& chunk) override {
            chunks[chunk.number] = {{chunk.places.begin(), chunk.places.end()}, {chunk.state.begin(), chunk.state.end()}};
            return {};
        }
        bool take_as_before(std::size_t number) override {
            if (before == nullptr || !before->contains(number)) return false;
            chunks[number] = before->at(number);
            ++taken;
            return true;
        }
        Result<void> rest(BlockView rest) override {
            the_rest.assign(rest.begin(), rest.end());
            return {};
        }
        std::size_t catoms, taken = 0;
        const Chunks* before;
        Chunks chunks;
        Block the_rest;
    };

    ChangedChunks changed_;
    Chunks last_;
    std::size_t taken_ = 0, made_ = 0;
};

}  // namespace meld::sim
