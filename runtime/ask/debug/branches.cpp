#include "runtime/ask/debug/branches.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <utility>

namespace meld::debug {

Result<Answer> Branches::fork(timeline::Timeline& timeline, const ByHand& by_hand, const std::string& name) {
    if (std::ranges::find(branches_, name, &Branch::name) != branches_.end())
        return fail(fmt::format("fork: there is a branch {} already", name), "`branches` lists them");
    Branch& left = branches_[present_];
    left.tick = timeline.tick();
    left.done = by_hand.state();
    branches_.push_back({.name = name});
    present_ = branches_.size() - 1;
    return all(timeline, by_hand);
}

Result<Answer> Branches::go_to(timeline::Timeline& timeline, ByHand& by_hand, const std::string& name) {
    const auto wanted = std::ranges::find(branches_, name, &Branch::name);
    if (wanted == branches_.end()) {
        std::vector<std::string> names;
        for (const Branch& b : branches_) names.push_back(b.name);
        return fail(fmt::format("switch: there is no branch {}", name), fmt::format("There are {}", fmt::join(names, ", ")));
    }
    const std::int64_t from = timeline.tick();
    const auto moved = [&] {
        return Moved{.from = from, .tick = timeline.tick(), .ended = timeline.ended(), .branch = branches_[present_].name};
    };
    const auto number = static_cast<std::size_t>(wanted - branches_.begin());
    if (number == present_) return moved();
    Branch& left = branches_[present_];
    left.tick = from;
    left.done = by_hand.state();
    // Before that tick both are the same run.
    if (const std::optional<std::int64_t> parts = by_hand.parts_from(wanted->done)) {
        if (from >= *parts)
            if (auto back = timeline.to(*parts - 1); !back) return tl::unexpected<Error>(back.error());
        by_hand.restore(wanted->done);
        timeline.changes_from_here();
    }
    present_ = number;
    if (auto there = timeline.to(wanted->tick); !there) return tl::unexpected<Error>(there.error());
    return moved();
}

BranchesFound Branches::all(timeline::Timeline& timeline, const ByHand& by_hand) const {
    BranchesFound found;
    for (std::size_t i = 0; i < branches_.size(); ++i) {
        const bool present = i == present_;
        found.branches.push_back({.name = branches_[i].name,
                                  .tick = present ? timeline.tick() : branches_[i].tick,
                                  .events = present ? by_hand.state().done.size() : branches_[i].done.done.size(),
                                  .present = present});
    }
    return found;
}

std::vector<std::string> Branches::keep_the_present() {
    std::vector<std::string> gone;
    std::swap(branches_.front(), branches_[present_]);
    for (std::size_t i = 1; i < branches_.size(); ++i) gone.push_back(branches_[i].name);
    branches_.resize(1);
    present_ = 0;
    return gone;
}

}  // namespace meld::debug
