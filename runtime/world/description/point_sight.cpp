#include "runtime/world/description/point_sight.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "runtime/base/assert.h"
#include "runtime/world/description/obstacles.h"

namespace meld::world {

namespace {

physics::Obstacles obstacles_in_way(const RangeOptions& links) {
    Result<physics::Obstacles> all = obstacles_of_points(links);
    MELD_CHECK(all.has_value(), "{}", all.error().problem);
    return std::move(*all);
}

}  // namespace

PointSight::PointSight(const RangeOptions& links)
    : radius_(links.thickness / 2),
      obstacles_(obstacles_in_way(links)),
      // Points that are not in the way are looked for nowhere.
      points_(radius_ > 0 ? radius_ : links.range, radius_ > 0 ? radius_ : links.range) {}

void PointSight::set(graph::Node node, const graph::Point& at) { points_.set(node, {{at[0], at[1], at[2]}, {{}, radius_}, {}}); }

bool PointSight::sees(graph::Node one, graph::Node other) const {
    const auto [low, high] = std::minmax(one, other);
    // Points without thickness are in nobody's way, even on the very line.
    return radius_ > 0 ? in_sight(obstacles_, points_, low, high) : is_free(obstacles_, points_, low, high);
}

std::function<bool(graph::Node, graph::Node)> sight_in(const graph::Graph& graph, const RangeOptions& links) {
    if (!links.sight) return {};
    const auto sight = std::make_shared<PointSight>(links);
    for (graph::Node node = 0; node < graph.nodes(); ++node)
        if (std::ranges::all_of(graph.places[node], [](double x) { return std::isfinite(x); })) sight->set(node, graph.places[node]);
    return [sight](graph::Node one, graph::Node other) { return sight->sees(one, other); };
}

}  // namespace meld::world
