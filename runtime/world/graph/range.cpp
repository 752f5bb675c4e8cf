#include "runtime/world/graph/range.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/hash.h"
#include "runtime/world/graph/memory_check.h"

namespace meld::graph {
namespace {

// A coordinate divided by the side of a cell is not exact; no rounding may lead two cells further.
constexpr double kWider = 1.0001;
// Cells beyond are one cell: points there are still found.
constexpr double kFarthest_cell = 1 << 30;
// What a circle covers of nine squares, and a ball of 27 cubes: so many of the candidates are in range where points are spread evenly.
constexpr double kShare_flat = 3.1416 / 9, kShare_solid = 4.1888 / 27;

}  // namespace

PointGrid::PointGrid(double range) : range_(range), side_(range * kWider) { MELD_EXPECT(range > 0, "range {}", range); }

std::size_t PointGrid::HashOfCell::operator()(const Cell& cell) const {
    std::uint64_t hash = 0;
    for (const std::int32_t x : cell) hash = hash_combine(hash, static_cast<std::uint32_t>(x));
    return hash;
}

PointGrid::Cell PointGrid::cell_of(const Point& at) const {
    Cell cell{};
    for (std::size_t i = 0; i < 3; ++i)
        cell[i] = static_cast<std::int32_t>(std::floor(std::clamp(at[i] / side_, -kFarthest_cell, kFarthest_cell)));
    return cell;
}

void PointGrid::add(Node point, const Point& at) {
    if (next_.size() <= point) next_.resize(point + std::size_t{1}, kNone), before_.resize(point + std::size_t{1}, kNone);
    const auto [found, fresh] = first_.try_emplace(cell_of(at), kNone);
    next_[point] = std::exchange(found->second, point);
    before_[point] = kNone;
    if (next_[point] != kNone) before_[next_[point]] = point;
}

void PointGrid::remove(Node point, const Point& from) {
    const Node next = next_[point], before = before_[point];
    if (next != kNone) before_[next] = before;
    if (before != kNone) {
        next_[before] = next;
        return;
    }
    const auto found = first_.find(cell_of(from));
    MELD_CHECK(found != first_.end() && found->second == point, "point {} is not in its cell", point);
    if (next == kNone)
        first_.erase(found);
    else
        found->second = next;
}

void PointGrid::move(Node point, const Point& from, const Point& to) {
    if (cell_of(from) == cell_of(to)) return;
    remove(point, from);
    add(point, to);
}

double PointGrid::candidates() const {
    const auto count = [&](Node first) {
        double points = 0;
        for (Node point = first; point != kNone; point = next_[point]) ++points;
        return points;
    };
    double all = 0;
    for (const auto& [cell, first] : first_) {
        double around = 0;
        each_around(cell, [&](Node other) { around += count(other); });
        all += around * count(first);
    }
    return all;
}

std::size_t PointGrid::bytes() const {
    return (next_.capacity() + before_.capacity()) * sizeof(Node) + first_.size() * (sizeof(Cell) + sizeof(Node) + 2 * sizeof(void*));
}

Result<void> link_within(Graph& graph, double range, const std::string& what, const MemoryLimit& room, const Sees& sees) {
    const auto nodes = static_cast<Node>(graph.nodes());
    MELD_EXPECT(graph.places.size() == nodes && graph.links() == 0, "{} places, {} nodes", graph.places.size(), nodes);
    PointGrid grid(range);
    bool flat = true;
    for (Node node = 0; node < nodes; ++node) {
        const Point& at = graph.places[node];
        if (!std::ranges::all_of(at, [](double x) { return std::isfinite(x); }))
            return fail(fmt::format("{}: the place of node {} is not finite", what, graph.id(node)), "write numbers");
        flat = flat && at[2] == 0;
        grid.add(node, at);
    }
    const double about = grid.candidates() * (flat ? kShare_flat : kShare_solid) / 2;
    if (about > kMaxLinks)
        return fail(
            fmt::format("{}: about {:.1e} links are within the range {}, and a graph has at most {:.0e}", what, about, range, kMaxLinks),
            "make the range smaller");
    if (auto fits = check_memory(what, nodes, about, kMaking_node * nodes + kMaking_link * about, room); !fits) return fits;
    std::vector<Link> links;
    for (Node node = 0; node < nodes; ++node)
        grid.each_within(node, graph.places, [&](Node other) {
            if (node < other && (!sees || sees(node, other))) links.push_back({node, other});
        });
    Graph linked = make(nodes, std::move(links)).graph;
    graph.first = std::move(linked.first), graph.to = std::move(linked.to);
    return {};
}

}  // namespace meld::graph
