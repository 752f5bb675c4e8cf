#include "runtime/sim/lattice/around.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "runtime/base/assert.h"

namespace meld::sim {

namespace {

using world::Cell;
using world::Lattice;
using world::LatticeKind;

class Surroundings {
  public:
    Surroundings(const Lattice& lattice, const std::function<bool(Cell)>& full, Cell mover, int pivot, Cell beside)
        : lattice_(lattice),
          full_(full),
          mover_(mover),
          pivot_(lattice.neighbour(mover, pivot)),
          beside_(beside),
          pivot_port_(pivot),
          ports_(lattice.ports()) {
        MELD_EXPECT(pivot >= 0 && pivot < ports_, "port {} of {}", pivot, ports_);
        MELD_EXPECT(full(pivot_) && pivot_ != beside, "a catom goes around the empty cell {} {} {}", pivot_.x, pivot_.y, pivot_.z);
        const world::Vec3 zero = lattice.position({});
        for (int port = 0; port < ports_; ++port) {
            const world::Vec3 at = lattice.position(lattice.neighbour({}, port));
            for (std::size_t i = 0; i < 3; ++i) step_[static_cast<std::size_t>(port)][i] = at[i] - zero[i];
        }
    }

    std::optional<WayAround> find() {
        if (cubes())
            for (int port = 0; port < ports_; ++port)
                if (auto way = slide(port)) return way;
        return walk();
    }

  private:
    bool cubes() const { return lattice_.kind() == LatticeKind::Cubic || lattice_.kind() == LatticeKind::Square; }
    bool free(Cell c) const { return c == mover_ || !full_(c); }
    Cell at(int port) const { return lattice_.neighbour(pivot_, port); }  // The cell beside the pivot.
    Cell beyond(Cell cell, int port, int other) const { return lattice_.neighbour(lattice_.neighbour(cell, port), other); }
    // The angle between two ports as the distance between their cells: 1 for 60 degrees, 1.41 for 90.
    double apart(int a, int b) const {
        double sum = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const double d = step_[static_cast<std::size_t>(a)][i] - step_[static_cast<std::size_t>(b)][i];
            sum += d * d;
        }
        return std::sqrt(sum);
    }
    bool touching(int a, int b) const { return std::abs(apart(a, b) - 1) < 0.01; }
    bool square(int a, int b) const { return std::abs(apart(a, b) - std::sqrt(2.0)) < 0.01; }
    bool reached(Cell cell) const {
        for (int port = 0; port < ports_; ++port)
            if (lattice_.neighbour(cell, port) == beside_) return true;
        return false;
    }

    // Along the pivot, in a straight line: the next catom to slide along must exist.
    std::optional<WayAround> slide(int towards) const {
        if (!square(pivot_port_, towards)) return std::nullopt;
        const Cell to = lattice_.neighbour(mover_, towards), ground = lattice_.neighbour(pivot_, towards);
        if (full_(to) || !full_(ground) || !reached(to)) return std::nullopt;
        return WayAround{.to = to, .direction = direction(ports_ + towards), .empty = {to}, .bodies = {mover_, pivot_, ground}};
    }
    int direction(int end) const { return pivot_port_ * 2 * kMaxPorts + end; }

    // Breadth first over the cells beside the pivot.
    std::optional<WayAround> walk() const {
        const int start = lattice_.opposite(pivot_port_);
        std::array<int, kMaxPorts> from;
        from.fill(-1);
        from[static_cast<std::size_t>(start)] = start;
        std::vector<int> now = {start};
        while (!now.empty()) {
            std::vector<int> next;
            for (int port = 0; port < ports_; ++port) {
                if (from[static_cast<std::size_t>(port)] >= 0) continue;
                const auto before = std::find_if(now.begin(), now.end(), [&](int a) { return needs(a, port).has_value(); });
                if (before == now.end()) continue;
                from[static_cast<std::size_t>(port)] = *before;
                next.push_back(port);
                if (reached(at(port))) return way(from, port);
            }
            now = std::move(next);
        }
        return std::nullopt;
    }
    WayAround way(const std::array<int, kMaxPorts>& from, int end) const {
        WayAround way{.to = at(end), .direction = direction(end), .empty = {}, .bodies = {mover_, pivot_, beside_}};
        for (int port = end; from[static_cast<std::size_t>(port)] != port; port = from[static_cast<std::size_t>(port)]) {
            const std::optional<std::vector<Cell>> step = needs(from[static_cast<std::size_t>(port)], port);
            way.empty.insert(way.empty.end(), step->begin(), step->end());
        }
        MELD_ENSURE(!full_(way.to) && reached(way.to), "the way ends in {} {} {}", way.to.x, way.to.y, way.to.z);
        std::erase(way.empty, mover_);
        std::sort(way.empty.begin(), way.empty.end());
        way.empty.erase(std::unique(way.empty.begin(), way.empty.end()), way.empty.end());
        return way;
    }

    // The cells that a step from one port of the pivot to another needs empty; none if it is impossible.
    std::optional<std::vector<Cell>> needs(int a, int b) const {
        switch (lattice_.kind()) {
            case LatticeKind::Square:
            case LatticeKind::Cubic:
                return turn(a, b);
            case LatticeKind::Hex:
                return touching(a, b) ? all_free({at(b), beyond(pivot_, a, b)}) : std::nullopt;
            case LatticeKind::Fcc:
                return roll(a, b);
        }
        return std::nullopt;
    }
    std::optional<std::vector<Cell>> all_free(std::vector<Cell> cells) const {
        return std::all_of(cells.begin(), cells.end(), [&](Cell c) { return free(c); }) ? std::optional(std::move(cells)) : std::nullopt;
    }
    // Around an edge: with P the step to the pivot and D that of b, the cells P + D, D, 2D, P + 2D, -P and D - P, seen from a.
    std::optional<std::vector<Cell>> turn(int a, int b) const {
        if (!square(a, b)) return std::nullopt;
        const Cell here = at(a);
        const Cell outside = lattice_.neighbour(here, a), along = lattice_.neighbour(here, b);
        return all_free(
            {at(b), along, lattice_.neighbour(along, b), lattice_.neighbour(at(b), b), outside, lattice_.neighbour(outside, b)});
    }
    // Over a face of the pivot, of three or four of its ports. The rest of the face is empty, nothing is behind the ends as seen from the
    // pivot, and no two opposite neighbours enclose the end.
    std::optional<std::vector<Cell>> roll(int a, int b) const {
        if (!touching(a, b) && !square(a, b)) return std::nullopt;
        auto cells = all_free({at(b), beyond(pivot_, a, a), beyond(pivot_, b, b)});
        if (!cells) return std::nullopt;
        for (int port = 0; port < ports_; ++port) {
            const int other = lattice_.opposite(port);
            const Cell one = lattice_.neighbour(at(b), port), two = lattice_.neighbour(at(b), other);
            if (port > other || one == pivot_ || two == pivot_) continue;
            if (!free(one) && !free(two)) return std::nullopt;
            cells->push_back(free(one) ? one : two);
        }
        for (const std::vector<int>& face : faces(a, b)) {
            std::vector<Cell> rest;
            for (const int port : face) rest.push_back(at(port));
            if (const auto empty = all_free(rest)) {
                cells->insert(cells->end(), empty->begin(), empty->end());
                return cells;
            }
        }
        return std::nullopt;
    }
    // The faces that have both, the smaller first, each as its other ports.
    std::vector<std::vector<int>> faces(int a, int b) const {
        std::vector<std::vector<int>> found;
        const auto around = [&](int p, int q) {
            std::vector<int> common;
            for (int port = 0; port < ports_; ++port)
                if (port != p && port != q && touching(port, p) && touching(port, q)) common.push_back(port);
            return common;
        };
        if (square(a, b)) return {around(a, b)};
        for (const int c : around(a, b)) found.push_back({c});
        // A square: c is across from a and beside b, d across from b and beside a.
        for (int c = 0; c < ports_; ++c)
            for (int d = 0; d < ports_; ++d)
                if (square(a, c) && touching(b, c) && square(b, d) && touching(a, d) && touching(c, d)) found.push_back({c, d});
        return found;
    }

    const Lattice& lattice_;
    const std::function<bool(Cell)>& full_;
    Cell mover_, pivot_, beside_;
    int pivot_port_, ports_;
    std::array<world::Vec3, kMaxPorts> step_{};
};

}  // namespace

std::optional<WayAround> way_around(const Lattice& lattice, const std::function<bool(Cell)>& full, Cell mover, int pivot, Cell beside) {
    return Surroundings(lattice, full, mover, pivot, beside).find();
}

}  // namespace meld::sim
