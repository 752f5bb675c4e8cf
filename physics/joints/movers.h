// What joints hold together: bodies, and the composites that move some of them.
#pragma once

#include <cstdint>

#include "physics/bodies/bodies.h"
#include "physics/bodies/body_shape.h"
#include "physics/bodies/composites.h"

namespace meld::physics {

struct Movers {
    Bodies& bodies;
    const BodyShapes& shapes;
    Composites& composites;

    // What moves a body that is here: itself, or the lowest body of its composite. kMaxBodies: nothing can.
    BodyId of(BodyId body) const {
        if (composites.immovable(bodies.properties[bodies.slot(body)])) return kMaxBodies;
        const std::uint32_t composite = composites.composite_of(body);
        return composite == kNoComposite ? body : composites.members(composites.all()[composite]).front().id;
    }
    // None if nothing moves it, or it moves by itself.
    std::uint32_t composite_of(BodyId body) const { return composites.mover_of(body); }
};

}  // namespace meld::physics
