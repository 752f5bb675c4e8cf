// The compounds of a world as the physics knows them, and what catoms that are compounds look like in recordings.
#pragma once

#include <optional>
#include <vector>

#include "physics/bodies/body_shape.h"
#include "runtime/world/description/physics_options.h"
#include "runtime/world/shapes/rounded_body.h"

namespace meld::world {

// The parts of a compound from its centre of mass, with lengths in the unit in which a diameter of the world is `diameter`. The name of the
// shape is its place among the compounds of the world.
physics::BodyShape shape_of(const CompoundForm& compound, double diameter, std::size_t place);
// The same, and where its centre of mass is from the origin of its parts.
physics::PlacedCompound placed_compound(const CompoundForm& compound, double diameter, std::size_t place);
// Of all compounds of a world.
std::vector<physics::BodyShape> compounds_of(const PhysicsOptions& options, double diameter);

// What a body of a shape in metres looks like in a world whose catoms have this diameter in metres.
RoundedBody look_of(const physics::BodyShape& shape, const physics::Quat& turn, double diameter_m);

}  // namespace meld::world
