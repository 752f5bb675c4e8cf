// Places of nodes in pictures, in catom diameters.
#pragma once

#include <vector>

#include "runtime/world/graph/graph.h"

namespace meld::graph {

// Ring, row by row, and so on: neighbouring nodes are two diameters apart.
std::vector<Point> on_circle(Node n);
std::vector<Point> around_first(Node n);                      // The first in the middle, the others on a circle.
std::vector<Point> on_grid(Node n, Node width, Node height);  // Layers of width times height, one beside the other.
std::vector<Point> in_levels(Node n, Node children);          // Level by level from the top.
// Points of the unit square, with room for a diameter between them on average.
std::vector<Point> spread(std::vector<Point> places);

// For any other graph: distances from a few nodes that are far from each other, and of these the plane in which they differ most (Harel
// and Koren, "Graph drawing by high-dimensional embedding", GD 2002), each component by itself. The same for a graph always. Cost: a few
// passes over all links, fewer in a large graph.
std::vector<Point> by_distances(const Graph& graph);

}  // namespace meld::graph
