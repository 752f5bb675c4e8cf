#include "runtime/sim/bodies/step_advice.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "physics/bodies/settings.h"
#include "runtime/base/assert.h"
#include "runtime/base/default_time_scale.h"

namespace meld::sim {

// A soft contact between two bodies of equal mass m is a spring of stiffness m omega^2 / 2, where omega is a share of the rate of
// substeps, and the kth from the top carries k bodies.
std::optional<std::string> advice_on_step(const world::PhysicsOptions& options, double gravity, double diameter_m, double height_m,
                                          bool bounces) {
    MELD_EXPECT(diameter_m > 0 && height_m >= 0, "{} m, {} m high", diameter_m, height_m);
    constexpr double kMostSquashed = 0.02, kLongestOfFall = 1.0 / 30;
    if (gravity == 0) return std::nullopt;
    const double substep = options.step / options.substeps;
    const double omega = 2 * std::numbers::pi * physics::SolverSettings().stiffness_share / substep;
    const double bodies = std::round(height_m / diameter_m) + 1;
    const double squashed = options.solver == "soft" ? bodies * gravity / (omega * omega * diameter_m) : 0;
    const double of_fall = substep / std::sqrt(diameter_m / gravity);
    const double shorter = std::min(std::sqrt(kMostSquashed / squashed), bounces ? kLongestOfFall / of_fall : 1.0);
    if (!(shorter < 1)) return std::nullopt;
    const std::string trouble =
        squashed > kMostSquashed ? fmt::format("a column of {:.0f} of them is squashed by {:.2g} %", bodies, 100 * std::min(squashed, 1.0))
                                 : "they bounce less than their restitution says";
    const double wanted = options.step * shorter, natural = natural_step_s(diameter_m, gravity);
    const std::string cure = natural <= wanted ? fmt::format("Leave it out, for {:.2g} s, or write {:.2g} at most", natural, wanted)
                                               : fmt::format("Write {:.2g} at most, or more substeps", wanted);
    return fmt::format("[motion] step = {:.2g} is too long for catoms of {:.2g} m: {}. {}", options.step, diameter_m, trouble, cure);
}

}  // namespace meld::sim
