// The tree inside a Shape: solids at the leaves, combinations above them.
#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "runtime/world/model/solid.h"
#include "runtime/world/shapes/solids.h"

namespace meld::world {

// A model from a file. The point p of the world is the point p * units + centre of the model.
struct Modelled {
    std::shared_ptr<const model::Solid> solid;
    double units = 1;  // Of the model, in a catom diameter.
    Vec3 centre{};
};

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

// A point that turns with the solid.
Vec3 turned(const Vec3& p, const Rotated& by);

struct Scaled {
    Shape solid;
    double factor;
};

using Solid = std::variant<BoxSolid, Ball, Ellipsoid, Torus, Cylinder, Cone, Helix, Gyroid, Trumpet, Modelled, Union, Intersection,
                           Difference, Shell, Moved, Rotated, Scaled>;

struct Shape::Node {
    Solid solid;
    Box bounds;
    std::string text;
    // Whether there is a model in it whose surface is open, so that cells may be inside on one side of a hole and outside on the
    // other with no surface between them: distances then say nothing about whole boxes.
    bool open = false;
};

// Computes the bounds.
Shape make_shape(Solid solid, std::string text);

}  // namespace meld::world
