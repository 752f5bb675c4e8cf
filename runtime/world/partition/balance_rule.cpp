#include "runtime/world/partition/balance_rule.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "runtime/base/assert.h"

namespace meld::partition {

namespace {

// No process gets more than this many times its share of the catoms, apart from whole bricks: they take memory.
constexpr std::uint64_t kMostShares = 3;

// Divides bricks by their work and a little by their catoms, of which as much as is needed.
Partition divide_by_work(std::span<const BrickWork> bricks, int processes) {
    std::uint64_t work = 0, catoms = 0;
    for (const BrickWork& brick : bricks) work += brick.work, catoms += brick.catoms;
    // What all catoms weigh together. Where nothing works, only they count.
    const std::uint64_t common = std::max(work, catoms);
    const std::uint64_t most = kMostShares * catoms / static_cast<std::uint64_t>(processes) + kBrickCells;
    std::vector<std::pair<BrickKey, std::uint32_t>> weights(bricks.size());
    for (std::uint64_t parts = 64;; parts /= 4) {
        for (std::size_t i = 0; i < bricks.size(); ++i) {
            const std::uint64_t weight = parts * bricks[i].work + common * bricks[i].catoms / catoms;
            weights[i] = {bricks[i].key, static_cast<std::uint32_t>(std::clamp<std::uint64_t>(weight, 1, ~std::uint32_t{0}))};
        }
        Partition next(weights, processes);
        std::vector<std::uint64_t> owned(static_cast<std::size_t>(processes));
        for (const BrickWork& brick : bricks) owned[static_cast<std::size_t>(next.owner(brick.key))] += brick.catoms;
        if (parts == 0 || std::ranges::max(owned) <= most) return next;
    }
}

}  // namespace

void BalanceRule::end_window(std::span<const std::uint64_t> work_of_process) {
    MELD_EXPECT(!work_of_process.empty());
    const std::uint64_t greatest = std::ranges::max(work_of_process);
    const std::uint64_t mean = std::accumulate(work_of_process.begin(), work_of_process.end(), std::uint64_t{0}) / work_of_process.size();
    lost_ += greatest - mean;
    greatest_ += greatest;
    all_ += mean;
}

std::uint64_t BalanceRule::most_moved(std::span<const BrickWork> bricks, const Partition& now, const Partition& next) {
    std::vector<std::uint64_t> moved(static_cast<std::size_t>(now.processes()));
    for (const BrickWork& brick : bricks) {
        const int owner = now.owner(brick.key), later = next.owner(brick.key);
        if (owner == later) continue;
        for (const int process : {owner, later}) moved[static_cast<std::size_t>(process)] += brick.catoms;
    }
    return std::ranges::max(moved);
}

std::optional<Partition> BalanceRule::divide(std::span<const BrickWork> bricks, const Partition& now, std::int64_t tick) {
    if (bricks.empty()) return std::nullopt;
    Partition next = divide_by_work(bricks, now.processes());
    std::vector<std::uint64_t> before(static_cast<std::size_t>(now.processes())), after(before.size());
    std::uint64_t moved = 0;
    for (const BrickWork& brick : bricks) {
        const int owner = now.owner(brick.key), later = next.owner(brick.key);
        before[static_cast<std::size_t>(owner)] += brick.work;
        after[static_cast<std::size_t>(later)] += brick.work;
        if (owner != later) moved += brick.catoms;
    }
    if (!always_) {
        // Not worth a tenth: whatever is wrong, this is not the cure, and is not looked at again before as much is lost again.
        if (moved == 0 || 10 * std::ranges::max(after) > 9 * std::ranges::max(before)) {
            enough_ = 2 * lost_;
            return std::nullopt;
        }
        enough_ = std::max(kCostOfMove * most_moved(bricks, now, next), kLeastLoss);
        if (lost_ < enough_) return std::nullopt;
    }
    if (moved == 0) return std::nullopt;
    divisions_.push_back({tick, moved, imbalance()});
    lost_ = greatest_ = all_ = 0;
    enough_ = kLeastLoss;
    return next;
}

}  // namespace meld::partition
