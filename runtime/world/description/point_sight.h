// Which points of a world with [links] sight = true see each other: nothing is on the straight line between their places.
#pragma once

#include <functional>

#include "physics/collision/sight.h"
#include "runtime/world/description/world.h"
#include "runtime/world/graph/graph.h"

namespace meld::world {

class PointSight {
  public:
    // The obstacles are right: they have been read. Without points.
    explicit PointSight(const RangeOptions& links);
    // A point is there, or elsewhere from now on.
    void set(graph::Node node, const graph::Point& at);
    // It is in nobody's way any more.
    void remove(graph::Node node) { points_.remove(node); }
    // The same for both. Cost: see physics::RayGrid.
    bool sees(graph::Node one, graph::Node other) const;

  private:
    double radius_;
    physics::Obstacles obstacles_;
    physics::RayGrid points_;
};

// Whether two points of a graph that is being made see each other; empty where that does not matter.
std::function<bool(graph::Node, graph::Node)> sight_in(const graph::Graph& graph, const RangeOptions& links);

}  // namespace meld::world
