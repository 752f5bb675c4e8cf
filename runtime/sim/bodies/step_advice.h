// Whether the steps of a world are short enough for its bodies.
#pragma once

#include <optional>
#include <string>

#include "runtime/world/description/physics_options.h"

namespace meld::sim {

// What is wrong with the steps and what to write instead, or nothing, for the greatest gravity of a run, m/s^2. Soft contacts give way: a
// column of catoms of this diameter, as high as the ensemble is along gravity at the start, should not be squashed by more than two
// percent; and if anything bounces, a step should be short compared with the time in which a body falls its own diameter. The cost is
// negligible.
std::optional<std::string> advice_on_step(const world::PhysicsOptions& options, double gravity, double diameter_m, double height_m,
                                          bool bounces);

}  // namespace meld::sim
