#include "runtime/show/view/kept/cell_box.h"

#include <algorithm>

namespace meld::view {

void CellBox::Bounds::include(const Bounds& other) {
    if (other.empty()) return;
    if (empty()) {
        *this = other;
        return;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], other.low[axis]);
        high[axis] = std::max(high[axis], other.high[axis]);
    }
}

world::Cell CellBox::straight(world::Cell cell) const {
    if (!shears_) return cell;
    return {cell.x - (cell.z >> 1), cell.y - (cell.z >> 1), cell.z};
}

CellBox::Bounds CellBox::bounds_of(world::Cell first, world::Cell last) const {
    Bounds out{.low = {first.x, first.y, first.z}, .high = {last.x, last.y, last.z}};
    if (!shears_) return out;
    for (const std::size_t axis : {0, 1}) {
        out.low[axis] -= last.z >> 1;
        out.high[axis] -= first.z >> 1;
    }
    return out;
}

bool CellBox::grow(const Bounds& bounds) {
    Bounds now = bounds_;
    now.include(bounds);
    if (now == bounds_) return false;
    bounds_ = now;
    for (std::size_t axis = 0; axis < 3; ++axis) sizes_[axis] = static_cast<std::uint32_t>(now.high[axis] - now.low[axis]) + 3;
    return true;
}

double CellBox::size() const { return double{1} * sizes_[0] * sizes_[1] * sizes_[2]; }

std::uint32_t CellBox::number(world::Cell cell) const {
    const world::Cell at = straight(cell);
    const auto along = [&](std::int32_t x, std::size_t axis) { return static_cast<std::uint32_t>(x - bounds_.low[axis]) + 1; };
    return along(at.x, 0) + sizes_[0] * (along(at.y, 1) + sizes_[1] * along(at.z, 2));
}

world::Cell CellBox::cell(std::uint32_t number) const {
    const std::uint32_t row = number / sizes_[0], layer = row / sizes_[1];
    const auto along = [&](std::uint32_t x, std::size_t axis) { return static_cast<std::int32_t>(x) - 1 + bounds_.low[axis]; };
    world::Cell out{along(number % sizes_[0], 0), along(row % sizes_[1], 1), along(layer, 2)};
    if (shears_) out.x += out.z >> 1, out.y += out.z >> 1;
    return out;
}

std::vector<std::ptrdiff_t> CellBox::ways(const world::Lattice& lattice) const {
    std::vector<std::ptrdiff_t> out;
    for (int port = 0; port < lattice.ports(); ++port) {
        const world::Cell to = straight(lattice.neighbour({0, 0, 0}, port));
        out.push_back(to.x + static_cast<std::ptrdiff_t>(sizes_[0]) * (to.y + static_cast<std::ptrdiff_t>(sizes_[1]) * to.z));
    }
    return out;
}

}  // namespace meld::view
