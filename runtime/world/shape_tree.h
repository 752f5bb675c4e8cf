// The tree inside a Shape: solids at the leaves, combinations above them.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "runtime/world/solids.h"

namespace meld::world {

struct Union {
    std::vector<Shape> parts;
};

struct Intersection {
    std::vector<Shape> parts;
};

struct Difference {
    Shape whole;
    std::vector<Shape> without;
};

// Points of `solid` that are nearer than `thickness` to its surface.
struct Shell {
    Shape solid;
    double thickness;
};

struct Moved {
    Shape solid;
    Vec3 by;
};

// A rotation about axis 0, 1 or 2.
struct Rotated {
    Shape solid;
    std::size_t axis;
    double sine, cosine;
};

struct Scaled {
    Shape solid;
    double factor;
};

using Solid = std::variant<BoxSolid, Ball, Ellipsoid, Torus, Cylinder, Cone, Helix, Gyroid, Trumpet, Union, Intersection, Difference, Shell,
                           Moved, Rotated, Scaled>;

struct Shape::Node {
    Solid solid;
    Box bounds;
    std::string text;
};

// Computes the bounds.
Shape make_shape(Solid solid, std::string text);

}  // namespace meld::world
