// The generators themselves: lists of links for arguments that have been checked.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "runtime/world/graph/draws.h"
#include "runtime/world/graph/graph.h"

namespace meld::graph {

using Links = std::vector<Link>;

// ---- regular_graphs.cpp
Links line(Node n);
Links ring(Node n);
Links star(Node n);  // Node 0 in the middle.
Links complete(Node n);
// Nodes are numbered x + w * (y + h * z). A torus closes each side that has three nodes or more.
Links grid(Node w, Node h, Node d, bool closed);
Links hypercube(int dimensions);
Links tree(Node n, Node children);  // The parent of node i is (i - 1) / children.

// ---- random_graphs.cpp
// Each pair is linked with probability p (Batagelj and Brandes, "Efficient generation of large random networks", Phys. Rev. E 71, 2005).
Links random(Node n, double p, Draws draws);
// Each node has d links: a random pairing of ends, in which links that are not allowed exchange ends with others. None: no such graph was
// found, though there may be one. n * d is even, and d < n.
std::optional<Links> regular(Node n, Node d, Draws draws);
// Points of the unit square, linked up to the distance r.
Links geometric(Node n, double r, Draws draws, std::vector<Point>& places);
// Points without links, around the origin: of a box with these sides, or of a ball in the plane or in space.
std::vector<Point> points_in_box(Node n, const Point& sides, Draws draws);
std::vector<Point> points_in_ball(Node n, double radius, std::size_t dimensions, Draws draws);
// Each node after the first m + 1 is linked with m earlier ones, chosen in proportion to their links (Barabasi and Albert).
Links scale_free(Node n, Node m, Draws draws);
// A ring in which each node is linked with the nearest k, and each link leads elsewhere with probability p (Watts and Strogatz). k is even.
Links small_world(Node n, Node k, double p, Draws draws);

}  // namespace meld::graph
