#include "tests/reference/programs/shrink.h"

#include <algorithm>

namespace meld::reference {

namespace {

class Shrinker {
  public:
    Shrinker(Trial trial, const std::function<bool(const Trial&)>& fails, int attempts)
        : trial_(std::move(trial)), fails_(fails), attempts_(attempts) {}

    Trial run() {
        for (bool smaller = true; smaller && attempts_ > 0;) {
            smaller = false;
            // Large pieces first: half of the list at a time, then ever less.
            smaller = thin([](Trial& t) -> auto& { return t.draft.rules; }) || smaller;
            smaller = thin([](Trial& t) -> auto& { return t.world.bursts; }) || smaller;
            for (std::size_t b = trial_.world.bursts.size(); b-- > 0;)
                smaller = thin([b](Trial& t) -> auto& { return t.world.bursts[b]; }) || smaller;
            smaller = thin([](Trial& t) -> auto& { return t.world.cells; }) || smaller;
            smaller = thin([](Trial& t) -> auto& { return t.world.links; }) || smaller;
            for (std::size_t r = trial_.draft.rules.size(); r-- > 0;) {
                smaller = thin([r](Trial& t) -> auto& { return t.draft.rules[r].body; }) || smaller;
                smaller = thin([r](Trial& t) -> auto& { return t.draft.rules[r].heads; }) || smaller;
            }
            smaller = unused_declarations() || smaller;
        }
        return std::move(trial_);
    }

  private:
    bool attempt(Trial&& less) {
        if (attempts_ <= 0) return false;
        --attempts_;
        if (less.world.bursts.empty() || less.world.cells.empty()) return false;
        std::erase_if(less.world.links, [&](const auto& link) {
            const auto gone = [&](std::uint64_t id) {
                return std::ranges::find(less.world.cells, retraction::node(id)) == less.world.cells.end();
            };
            return gone(link.first) || gone(link.second);
        });
        if (!fails_(less)) return false;
        trial_ = std::move(less);
        return true;
    }

    // Removes runs of elements of a list, shorter and shorter ones.
    template <class List>
    bool thin(const List& list_of) {
        bool any = false;
        for (std::size_t size = std::max<std::size_t>(1, list_of(trial_).size() / 2); size > 0; size /= 2)
            for (std::size_t i = list_of(trial_).size(); i > 0;) {
                i -= std::min(i, size);
                Trial less = trial_;
                auto& list = list_of(less);
                const std::size_t end = std::min(i + size, list.size());
                if (i >= end) continue;
                const auto from = std::next(list.begin(), static_cast<std::ptrdiff_t>(i)),
                           to = std::next(list.begin(), static_cast<std::ptrdiff_t>(end));
                list.erase(from, to);
                any = attempt(std::move(less)) || any;
            }
        return any;
    }

    // What is given stays: changes name it by number.
    bool unused_declarations() {
        bool any = false;
        for (std::size_t i = trial_.draft.declarations.size(); i-- > 0;) {
            Trial less = trial_;
            less.draft.declarations.erase(less.draft.declarations.begin() + static_cast<std::ptrdiff_t>(i));
            any = attempt(std::move(less)) || any;
        }
        return any;
    }

    Trial trial_;
    const std::function<bool(const Trial&)>& fails_;
    int attempts_;
};

}  // namespace

Trial shrink(Trial trial, const std::function<bool(const Trial&)>& fails, int attempts) {
    return Shrinker(std::move(trial), fails, attempts).run();
}

}  // namespace meld::reference
