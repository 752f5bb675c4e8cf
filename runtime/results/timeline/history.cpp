#include "runtime/results/timeline/history.h"

#include <algorithm>
#include <cstring>
#include <iterator>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"

namespace meld::timeline {

namespace {

// Takes a share, block by block, and shares each with a snapshot near in time if it is the same.
class Sharing : public sim::ShareSink {
  public:
    explicit Sharing(const KeptShare* alike) : alike_(alike) {}
    std::size_t chunk_catoms() const override { return sim::kCatomsOfASmallChunk; }
    Result<void> chunk(const sim::Chunk& chunk) override {
        share_.blocks.push_back(shared(chunk.places));
        share_.blocks.push_back(shared(chunk.state));
        return {};
    }
    Result<void> rest(sim::BlockView rest) override {
        share_.rest = own(rest);
        return {};
    }
    KeptShare take() { return std::move(share_); }
    // Of the blocks that are in no other snapshot.
    std::size_t own_bytes() const { return own_bytes_; }

  private:
    SharedBlock shared(sim::BlockView block) {
        const std::size_t at = share_.blocks.size();
        if (alike_ != nullptr && at < alike_->blocks.size() && same(*alike_->blocks[at], block)) return alike_->blocks[at];
        return own(block);
    }
    // The library compares bytes one by one.
    static bool same(sim::BlockView a, sim::BlockView b) { return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size()) == 0; }
    SharedBlock own(sim::BlockView block) {
        own_bytes_ += block.size();
        return std::make_shared<const sim::Block>(block.begin(), block.end());
    }

    const KeptShare* alike_;
    KeptShare share_;
    std::size_t own_bytes_ = 0;
};

// The blocks of all processes at one place in their shares; empty where a process has fewer.
std::vector<std::vector<std::byte>> gather_block(const SharedBlock* mine, comm::Communicator& comm) {
    return comm.allgather_any(mine == nullptr ? std::span<const std::byte>{} : std::span<const std::byte>(**mine));
}

}  // namespace

GatheredShares GatheredShares::gather(const KeptShare& mine, comm::Communicator& comm) {
    GatheredShares out;
    if (comm.processes() == 1) {
        out.shares_.push_back(mine);
        return out;
    }
    out.shares_.resize(static_cast<std::size_t>(comm.processes()));
    const auto add = [](std::vector<std::byte> bytes) { return std::make_shared<const sim::Block>(std::move(bytes)); };
    ByteWriter length;
    length.write(static_cast<std::uint64_t>(mine.blocks.size()));
    const std::vector<std::byte> lengths = comm.allgather(length.view());
    std::vector<std::uint64_t> counts(out.shares_.size());
    std::memcpy(counts.data(), lengths.data(), lengths.size());
    // Block by block, so that no message is large.
    const std::uint64_t most = *std::max_element(counts.begin(), counts.end());
    for (std::uint64_t at = 0; at < most; ++at) {
        auto all = gather_block(at < mine.blocks.size() ? &mine.blocks[at] : nullptr, comm);
        for (std::size_t p = 0; p < all.size(); ++p)
            if (at < counts[p]) out.shares_[p].blocks.push_back(add(std::move(all[p])));
    }
    auto rests = gather_block(&mine.rest, comm);
    for (std::size_t p = 0; p < rests.size(); ++p) out.shares_[p].rest = add(std::move(rests[p]));
    return out;
}

Result<void> History::keep(std::int64_t tick, const Save& save, comm::Communicator& comm) {
    MELD_EXPECT(!has(tick), "tick {} twice", tick);
    const auto alike = before(tick);
    Sharing share(alike ? alike->second : nullptr);
    if (auto saved = save(share); !saved) return saved;
    kept_[tick] = share.take();
    bytes_ += share.own_bytes();
    const auto too_large = [&] {
        const std::byte mine{bytes_ > most_bytes_};
        return std::ranges::any_of(comm.allgather({&mine, 1}), [](std::byte large) { return large != std::byte{0}; });
    };
    while (kept_.size() > 1 && too_large()) drop_one(kept_.rbegin()->first);
    return {};
}

// Snapshots so stay dense near the newest tick, and their distance grows with their age.
void History::drop_one(std::int64_t newest) {
    auto least = kept_.end();
    double least_loss = 0;
    std::int64_t from = 0;
    for (auto at = kept_.begin(); std::next(at) != kept_.end(); ++at) {
        const double gap = static_cast<double>(std::next(at)->first - from);
        const double loss = gap / static_cast<double>(newest - at->first + 1);
        if (least == kept_.end() || loss < least_loss) {
            least = at;
            least_loss = loss;
        }
        from = at->first;
    }
    release(least->second);
    kept_.erase(least);
}

void History::release(KeptShare& share) {
    const auto drop = [&](SharedBlock& block) {
        if (block.use_count() == 1) bytes_ -= block->size();
        block.reset();
    };
    for (SharedBlock& block : share.blocks) drop(block);
    drop(share.rest);
}

void History::forget_after(std::int64_t tick) {
    const auto first = kept_.upper_bound(tick);
    for (auto at = first; at != kept_.end(); ++at) release(at->second);
    kept_.erase(first, kept_.end());
}

std::optional<std::pair<std::int64_t, const KeptShare*>> History::before(std::int64_t tick) const {
    auto at = kept_.upper_bound(tick);
    if (at == kept_.begin()) return std::nullopt;
    --at;
    return std::pair{at->first, &at->second};
}

std::vector<std::int64_t> History::ticks() const {
    std::vector<std::int64_t> out;
    for (const auto& [tick, share] : kept_) out.push_back(tick);
    return out;
}

}  // namespace meld::timeline
