// Which points are within a range of each other, found by a grid of cells.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/base/process/available_memory.h"
#include "runtime/world/graph/graph.h"

namespace meld::graph {

inline double square_distance(const Point& a, const Point& b) {
    const double x = b[0] - a[0], y = b[1] - a[1], z = b[2] - a[2];
    return x * x + y * y + z * z;
}

// Cells that are a little wider than the range, so that what is in range of a point is in its cell or one of the 26 around. Only cells with
// points are stored. A point is known by its number; the caller keeps the places.
class PointGrid {
  public:
    explicit PointGrid(double range);

    // Cost: constant on average, like that of the next two.
    void add(Node point, const Point& at);
    void remove(Node point, const Point& from);
    void move(Node point, const Point& from, const Point& to);
    // Calls visit(point) for all other points that are not farther away than the range, in no particular order.
    template <class Visit>
    void each_within(Node point, std::span<const Point> places, const Visit& visit) const {
        const Point& here = places[point];
        each_around(cell_of(here), [&](std::uint32_t first) {
            for (Node other = first; other != kNone; other = next_[other])
                if (other != point && square_distance(here, places[other]) <= range_ * range_) visit(other);
        });
    }
    // The same for a place, where a point may be.
    template <class Visit>
    void each_near(const Point& here, std::span<const Point> places, const Visit& visit) const {
        each_around(cell_of(here), [&](std::uint32_t first) {
            for (Node other = first; other != kNone; other = next_[other])
                if (square_distance(here, places[other]) <= range_ * range_) visit(other);
        });
    }
    // How many pairs of points there are to look at, counting each twice, and each point with itself.
    double candidates() const;
    std::size_t bytes() const;

  private:
    static constexpr Node kNone = std::numeric_limits<Node>::max();
    using Cell = std::array<std::int32_t, 3>;
    struct HashOfCell {
        std::size_t operator()(const Cell& cell) const;
    };
    Cell cell_of(const Point& at) const;
    template <class Visit>
    void each_around(const Cell& cell, const Visit& visit) const {
        for (std::int32_t n = 0; n < 27; ++n)
            if (const auto found = first_.find({cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1}); found != first_.end())
                visit(found->second);
    }

    double range_, side_;
    std::unordered_map<Cell, Node, HashOfCell> first_;
    std::vector<Node> next_, before_;  // By point: the others of its cell.
};

// The graph of these points, each with a place; points within the range are linked. The columns of the nodes stay. Errors: `room` has no
// place for the links; a place is not finite. Cost: linear in nodes and links where points are spread evenly. `sees`: if it is given, only
// those that see each other.
using Sees = std::function<bool(Node, Node)>;
Result<void> link_within(Graph& graph, double range, const std::string& what, const MemoryLimit& room, const Sees& sees = {});

}  // namespace meld::graph
