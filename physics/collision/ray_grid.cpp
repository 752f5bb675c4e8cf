#include "physics/collision/ray_grid.h"

#include <algorithm>
#include <cmath>

#include "runtime/base/assert.h"
#include "runtime/base/hash.h"

namespace meld::physics {

namespace {

// A ball of the least radius has a cell to itself where they lie densely; a large one has not too many.
constexpr double kCellsInLeast = 4, kCellsInGreatest = 0.25;
// Bodies are in the cells around them too that they do not quite reach, as shares of a cell: no rounding may lead a ray past them.
constexpr double kWider = 1e-6;
// Cells beyond are one cell.
constexpr double kFarthestCell = 0x1p52;
constexpr double kEndless = std::numeric_limits<double>::infinity();

double axis_of(Vec3 v, std::size_t axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

}  // namespace

RayGrid::RayGrid(double least_radius_m, double greatest_radius_m)
    : side_(std::max(kCellsInLeast * least_radius_m, kCellsInGreatest * greatest_radius_m)),
      low_{kEndless, kEndless, kEndless},
      high_{-kEndless, -kEndless, -kEndless} {
    if (!(side_ > 0)) side_ = 1;
}

std::size_t RayGrid::HashOfCell::operator()(const Cell& cell) const {
    std::uint64_t hash = 0;
    for (const std::int64_t x : cell) hash = hash_combine(hash, static_cast<std::uint64_t>(x));
    return hash;
}

// Cells begin half a cell beside the origin, so that what lies in the plane is in one layer of them.
RayGrid::Cell RayGrid::cell_of(Vec3 at) const {
    Cell cell{};
    for (std::size_t i = 0; i < 3; ++i)
        cell[i] = static_cast<std::int64_t>(std::floor(std::clamp(axis_of(at, i) / side_ + 0.5, -kFarthestCell, kFarthestCell)));
    return cell;
}

RayGrid::Cells RayGrid::cells_of(const Thing& thing) const {
    const double reach = thing.shape.radius_m() + kWider * side_;
    return {cell_of(thing.centre - Vec3{reach, reach, reach}), cell_of(thing.centre + Vec3{reach, reach, reach})};
}

template <class Visit>
void RayGrid::each_cell(const Cells& cells, const Visit& visit) {
    for (std::int64_t x = cells.low[0]; x <= cells.high[0]; ++x)
        for (std::int64_t y = cells.low[1]; y <= cells.high[1]; ++y)
            for (std::int64_t z = cells.low[2]; z <= cells.high[2]; ++z) visit(Cell{x, y, z});
}

void RayGrid::set(Index index, const Thing& thing) {
    const Cells cells = cells_of(thing);
    if (things_.size() <= index) things_.resize(index + std::size_t{1});
    Entry& entry = things_[index];
    const double reach = thing.shape.radius_m() + side_;
    const Vec3 low = thing.centre - Vec3{reach, reach, reach}, high = thing.centre + Vec3{reach, reach, reach};
    low_ = {std::min(low_.x, low.x), std::min(low_.y, low.y), std::min(low_.z, low.z)};
    high_ = {std::max(high_.x, high.x), std::max(high_.y, high.y), std::max(high_.z, high.z)};
    if (entry.here && entry.cells == cells) {
        entry.thing = thing;
        return;
    }
    remove(index);
    entry = {thing, cells, true};
    ++count_;
    each_cell(cells, [&](const Cell& cell) { cells_[cell].push_back(index); });
}

void RayGrid::remove(Index index) {
    if (index >= things_.size() || !things_[index].here) return;
    things_[index].here = false;
    --count_;
    each_cell(things_[index].cells, [&](const Cell& cell) {
        const auto found = cells_.find(cell);
        MELD_ASSERT(found != cells_.end(), "body {} is in a cell that does not exist", index);
        std::erase(found->second, index);
        if (found->second.empty()) cells_.erase(found);
    });
}

// J. Amanatides, A. Woo: "A fast voxel traversal algorithm for ray tracing", 1987.
template <class Meet, class Done>
void RayGrid::walk(const Ray& ray, const Meet& meet, const Done& done) const {
    if (count_ == 0) return;
    const std::optional<RayPart> part = part_within(ray, low_, high_);
    if (!part) return;
    Cell cell = cell_of(ray.at(part->enter));
    const Cell last = cell_of(ray.at(part->leave));
    double steps = 0;
    for (std::size_t i = 0; i < 3; ++i) steps += std::abs(static_cast<double>(last[i] - cell[i]));
    // Through emptiness it is shorter to ask all.
    if (steps > static_cast<double>(2 * count_ + 8)) {
        for (Index index = 0; index < things_.size(); ++index)
            if (things_[index].here) meet(index);
        return;
    }
    std::array<double, 3> next{}, step{};
    std::array<std::int64_t, 3> sign{};
    for (std::size_t i = 0; i < 3; ++i) {
        const double way = axis_of(ray.way, i);
        sign[i] = way > 0 ? 1 : -1;
        const double border = (static_cast<double>(cell[i]) + (way > 0 ? 0.5 : -0.5)) * side_;
        next[i] = way == 0 || cell[i] == last[i] ? kEndless : (border - axis_of(ray.from, i)) / way;
        step[i] = way == 0 ? kEndless : side_ / std::abs(way);
    }
    for (auto left = static_cast<std::int64_t>(steps);; --left) {
        if (const auto found = cells_.find(cell); found != cells_.end())
            for (const Index index : found->second) meet(index);
        if (left <= 0) return;
        const std::size_t axis = next[0] <= next[1] && next[0] <= next[2] ? 0 : next[1] <= next[2] ? 1 : 2;
        if (done(next[axis])) return;
        cell[axis] += sign[axis];
        next[axis] = cell[axis] == last[axis] ? kEndless : next[axis] + step[axis];
    }
}

std::optional<double> RayGrid::first_on(const Ray& ray, Index but, Index and_but) const {
    std::optional<double> first;
    walk(
        ray,
        [&](Index index) {
            if (index == but || index == and_but) return;
            const Thing& one = things_[index].thing;
            const std::optional<double> met = physics::first_on(one.shape, one.centre, one.turn, ray);
            if (met && (!first || *met < *first)) first = met;
        },
        [&](double share) { return first && *first < share; });
    return first;
}

bool RayGrid::blocks(const Ray& ray, Index but, Index and_but) const {
    bool met = false;
    walk(
        ray,
        [&](Index index) {
            if (met || index == but || index == and_but) return;
            const Thing& one = things_[index].thing;
            met = physics::first_on(one.shape, one.centre, one.turn, ray).has_value();
        },
        [&](double) { return met; });
    return met;
}

}  // namespace meld::physics
