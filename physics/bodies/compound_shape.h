// What a compound of solids is as one body: for body_shape.cpp.
#pragma once

#include "physics/bodies/body_shape.h"

namespace meld::physics {

// See BodyShape::inertia and way_out_m. Cost of the first: some microseconds.
BodyShape::Inertia inertia_of_parts(const BodyShape& shape);
double way_out_of_parts(const BodyShape& shape, Vec3 direction);

// Errors: the parts are no compound; and of any shape, that it is far too slender.
Result<void> check_compound(const BodyShape& shape);
Result<void> check_thickness(const BodyShape& shape);

}  // namespace meld::physics
