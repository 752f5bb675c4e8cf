#include "runtime/show/render/callouts.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "runtime/base/assert.h"

namespace meld::render {

namespace {

// Labels side by side, from above, as near to the heights that they want as can be: those that are in each other's way stand together
// around the middle of what they want.
std::vector<double> spread(std::span<const double> wanted, const Columns& columns) {
    struct Group {
        double sum = 0;  // Of the heights that its first label should have for each of them.
        std::size_t count = 0;
        double top = 0;
    };
    std::vector<Group> groups;
    for (const double y : wanted) {
        Group last{.sum = y, .count = 1};
        const auto settle = [&] {
            const double lowest = columns.bottom - static_cast<double>(last.count - 1) * columns.step;
            last.top = std::clamp(last.sum / static_cast<double>(last.count), columns.top, std::max(lowest, columns.top));
        };
        settle();
        while (!groups.empty() && last.top < groups.back().top + static_cast<double>(groups.back().count) * columns.step) {
            const Group before = groups.back();
            groups.pop_back();
            last.sum += before.sum - static_cast<double>(last.count * before.count) * columns.step;
            last.count += before.count;
            settle();
        }
        groups.push_back(last);
    }
    std::vector<double> out;
    for (const Group& group : groups)
        for (std::size_t i = 0; i < group.count; ++i) out.push_back(group.top + static_cast<double>(i) * columns.step);
    return out;
}

// Whether the lines from two anchors to the ends of their labels cross.
bool cross(const Anchor& a, const Anchor& a_end, const Anchor& b, const Anchor& b_end) {
    const auto side = [](const Anchor& p, const Anchor& q, const Anchor& r) {
        return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
    };
    return side(a, a_end, b) * side(a, a_end, b_end) < 0 && side(b, b_end, a) * side(b, b_end, a_end) < 0;
}

// Exchanges labels whose lines cross. That makes both lines together shorter, so it ends.
void untangle(std::span<const Anchor> anchors, std::vector<std::size_t>& order, const std::vector<double>& heights, double end) {
    for (bool changed = true; std::exchange(changed, false);)
        for (std::size_t i = 0; i < order.size(); ++i)
            for (std::size_t j = i + 1; j < order.size(); ++j)
                if (cross(anchors[order[i]], {end, heights[i]}, anchors[order[j]], {end, heights[j]})) {
                    std::swap(order[i], order[j]);
                    changed = true;
                }
}

}  // namespace

std::vector<Label> place_labels(std::span<const Anchor> anchors, const Columns& columns) {
    const std::size_t capacity = columns.capacity();
    MELD_EXPECT(anchors.size() <= 2 * capacity, "{} labels in columns of {}", anchors.size(), capacity);
    // From left to right. Those that are nearer to the right have a place there unless that is full, and the other way round.
    std::vector<std::size_t> order(anchors.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return anchors[i].x; });
    const double middle = (columns.left + columns.right) / 2;
    auto at_left = static_cast<std::size_t>(std::ranges::count_if(anchors, [&](const Anchor& a) { return a.x < middle; }));
    at_left = std::clamp(at_left, anchors.size() - std::min(anchors.size(), capacity), std::min(anchors.size(), capacity));
    std::vector<Label> out(anchors.size());
    for (const bool right : {false, true}) {
        const auto split = order.begin() + static_cast<std::ptrdiff_t>(at_left);
        std::vector<std::size_t> those(right ? split : order.begin(), right ? order.end() : split);
        std::ranges::stable_sort(those, {}, [&](std::size_t i) { return anchors[i].y; });
        std::vector<double> wanted;
        for (const std::size_t i : those) wanted.push_back(anchors[i].y);
        const std::vector<double> heights = spread(wanted, columns);
        untangle(anchors, those, heights, right ? columns.right : columns.left);
        for (std::size_t i = 0; i < those.size(); ++i) out[those[i]] = {.right = right, .y = heights[i]};
    }
    return out;
}

}  // namespace meld::render
