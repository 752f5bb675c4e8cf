// All that migrates with a body from one subdomain to another.
#pragma once

#include "physics/solver/engine.h"
#include "runtime/base/bytes.h"

namespace meld::physics {

void pack_body(const World& world, std::uint32_t slot, ByteWriter& out);
// Adds the body: one of this subdomain, or a ghost if it is in a block of another. Errors: it is here already.
Result<void> unpack_body(World& world, ByteReader& in, const std::function<bool(const Place&)>& is_ours);

// The velocities of a body that change in a sweep.
struct PackedVelocity {
    BodyId id;
    float linear[3], surface[3];
};
inline PackedVelocity packed_velocity(const Bodies& bodies, std::uint32_t slot) {
    const BodyVelocity& velocity = bodies.velocity[slot];
    return {bodies.properties[slot].id,
            {velocity.linear[0], velocity.linear[1], velocity.linear[2]},
            {velocity.surface[0], velocity.surface[1], velocity.surface[2]}};
}

}  // namespace meld::physics
