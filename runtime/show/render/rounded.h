// Cubes with round edges and corners: all that is no further than a radius from a smaller cube.
#pragma once

#include <optional>

#include "runtime/show/render/scene.h"

namespace meld::render {

struct RoundedCube {
    Vec middle = Vec::Zero();
    float half = 0.5F;    // Of a side.
    float radius = 0.1F;  // Of its edges, at most `half`; 0: they are sharp.

    // How far a ray, whose direction has the length 1, goes until it enters the cube, up to a limit: 0 if it begins inside. Exact also for
    // rays that only graze an edge.
    std::optional<float> enters(const Vec& from, const Vec& along, float within) const;
    // Away from it, at a place on its surface; of length 1.
    Vec normal(const Vec& at) const;
    Vec reach() const { return Vec::Constant(half); }
};

// Boxes, cylinders, lines and balls with the same edges, turned about their middles.
struct RoundedBox {
    Vec middle = Vec::Zero();
    Vec half = Vec::Constant(0.5F);
    float radius = 0.1F;
    Eigen::Matrix3f turn = Eigen::Matrix3f::Identity();  // From its own frame.
    bool cylinder = false;                               // Along z, as wide as the box.

    static RoundedBox of(const RoundedBody& body, const Vec& middle);
    std::optional<float> enters(const Vec& from, const Vec& along, float within) const;
    Vec normal(const Vec& at) const;
    // Of the box along the axes around it.
    Vec reach() const { return turn.cwiseAbs() * (half - Vec::Constant(radius)) + Vec::Constant(radius); }
};

}  // namespace meld::render
