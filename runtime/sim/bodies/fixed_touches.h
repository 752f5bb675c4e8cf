// Which immovable or connected catoms touch each other at the start: the physics does not search for such pairs, because they have no
// effect on motion.
#pragma once

#include <cstdint>
#include <vector>

#include "physics/scene/scene.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

struct FixedBody {
    std::uint64_t id = 0;
    physics::Vec3 position_m = {};
    double radius_m = 0;
    physics::BodyShape shape = {};
    physics::Quat orientation = {};
};

// The touches among the given catoms of all processes, sorted; every process calls it with its own. Surfaces nearer than `touch_m` touch.
std::vector<physics::TouchEvent> touches_among(Subdomain& subdomain, const std::vector<FixedBody>& mine, double max_radius_m,
                                               double touch_m);

}  // namespace meld::sim
