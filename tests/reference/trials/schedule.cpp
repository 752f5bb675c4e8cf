#include "tests/reference/trials/schedule.h"

namespace meld::reference {

using retraction::Case;
using retraction::Change;

namespace {

// Most runs of these worlds come to rest in so many ticks; the next burst begins sooner now and then.
constexpr int kPause = 25, kAfter = 30;

}  // namespace

Case on_one_clock(const Case& world) {
    Case out = world;
    out.bursts.assign(1, {});
    retraction::Random random(world.seed);
    int start = 0;
    for (const std::vector<Change>& burst : world.bursts) {
        int last = start;
        for (Change change : burst) {
            change.tick += start;
            last = std::max(last, change.tick);
            out.bursts[0].push_back(change);
        }
        start = last + static_cast<int>(retraction::below(random, kPause));
    }
    return out;
}

std::int64_t last_tick(const Case& world) { return kAfter + (world.bursts[0].empty() ? 0 : world.bursts[0].back().tick); }

}  // namespace meld::reference
