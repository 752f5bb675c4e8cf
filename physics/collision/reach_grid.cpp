#include "physics/collision/reach_grid.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/base/release_memory.h"

namespace meld::physics {

ReachGrid::Cell ReachGrid::cell_at(int level, Vec3 at_m) {
    // No rounding may put what is within reach two cells away.
    constexpr double kSideShare = 1.001;
    // Beyond this a cell has no neighbours of other numbers; what is so far away compared with its reach shares one.
    constexpr double kFarthest = 1e15;
    const double side = kSideShare * std::ldexp(1.0, level);
    const auto number = [&](double x) { return static_cast<std::int64_t>(std::clamp(std::floor(x / side), -kFarthest, kFarthest)); };
    return {level, number(at_m.x), number(at_m.y), number(at_m.z)};
}

void ReachGrid::add(Vec3 place_m, double reach_m) {
    const std::uint32_t number = count_++;
    if (!std::isfinite(reach_m)) return everywhere_.push_back(number);
    int level = 0;
    std::frexp(reach_m, &level);
    entries_.push_back({cell_at(level, place_m), {place_m, reach_m, number}});
}

void ReachGrid::sort() {
    std::ranges::sort(entries_, {}, [](const Entry& entry) { return std::pair(entry.cell, entry.place.number); });
    for (const auto& [cell, place] : entries_) {
        if (levels_.empty() || levels_.back() != cell.level) levels_.push_back(cell.level);
        if (cells_.empty() || cells_.back().cell != cell) cells_.push_back({cell, static_cast<std::uint32_t>(places_.size())});
        places_.push_back(place);
    }
    release_memory(entries_);
}

void ReachGrid::find(Vec3 at_m, std::vector<std::uint32_t>& found) const {
    // No rounding may leave out what the caller finds within reach.
    constexpr double kNearly = 1 + 1e-9;
    found = everywhere_;
    for (const int level : levels_) {
        const Cell here = cell_at(level, at_m);
        for (std::int64_t x = -1; x <= 1; ++x)
            for (std::int64_t y = -1; y <= 1; ++y) {
                // Cells that differ in z alone follow each other.
                const Cell first{level, here.x + x, here.y + y, here.z - 1}, last{level, here.x + x, here.y + y, here.z + 1};
                const auto begin = std::ranges::lower_bound(cells_, first, {}, &First::cell);
                auto end = begin;
                while (end != cells_.end() && end->cell <= last) ++end;
                const std::size_t from = begin == cells_.end() ? places_.size() : begin->place;
                const std::size_t to = end == cells_.end() ? places_.size() : end->place;
                for (std::size_t i = from; i < to; ++i) {
                    const Place& place = places_[i];
                    const Vec3 way = place.at_m - at_m;
                    if (dot(way, way) <= kNearly * place.reach_m * place.reach_m) found.push_back(place.number);
                }
            }
    }
    std::ranges::sort(found);
}

}  // namespace meld::physics
