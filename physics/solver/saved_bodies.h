// Bodies in a snapshot of a scene: all that a body has between two steps, whichever engine moves it.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "physics/solver/engine.h"
#include "runtime/base/bytes.h"
#include "runtime/base/error.h"

namespace meld::physics {

// The bodies in these slots, in their order.
void save_bodies(const World& world, std::span<const std::uint32_t> slots, ByteWriter& out);

// Adds bodies that save_bodies wrote in the next slots, in the same order; masses are those of bodies that are awake. Errors: they
// cannot be bodies of this scene.
Result<void> load_bodies(World& world, Holds holds, ByteReader& in);

// Visits the numbers of such bodies and where they are, and makes nothing of them.
void each_saved_place(ByteReader& in, const std::function<void(BodyId, Vec3)>& visit);

// The error of a snapshot that says what cannot be.
tl::unexpected<Error> damaged_snapshot(const std::string& what);

}  // namespace meld::physics
