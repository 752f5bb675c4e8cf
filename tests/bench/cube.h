// The pile that the benchmarks of bodies measure.
#pragma once

#include "physics/scene/scene.h"
#include "tests/bench/need.h"

namespace meld::bench {

// Adds side^3 balls of the standard size on a plane at height 0; `spacing` is the distance between neighbours in metres.
inline void add_cube(physics::Scene& scene, int side, double spacing) {
    need(scene.add_obstacle(physics::Plane{}, 0));
    physics::BodyId id = 0;
    for (int z = 0; z < side; ++z)
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x)
                need(scene.add_body({.id = id++, .position_m = {spacing * x, spacing * y, spacing * (z + 0.5)}}));
}

}  // namespace meld::bench
