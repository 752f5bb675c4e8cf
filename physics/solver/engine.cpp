// What engines share: the rules of a step, errors, clocks.
#include "physics/solver/engine.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "physics/collision/broadphase.h"
#include "physics/solver/contacts.h"
#include "runtime/base/assert.h"
#include "runtime/base/default_time_scale.h"

namespace meld::physics {

namespace {

// A rate so high that a wider gap never needs an impulse, while its products stay finite.
constexpr float kNeverRate = 1e12f;

// Overlaps that no load presses together open at this share of the speed of bodies that fall their own diameter; overlaps that latches hold
// or a cold solver pushes, at about that speed.
constexpr double kUnloadedShare = 0.03, kFreeShare = 3 / 3.132;

double depenetration_speed_m_s(const Settings& settings, double diameter_m, double share) {
    if (settings.solver.max_depenetration_speed_m_s > 0) return settings.solver.max_depenetration_speed_m_s;
    return share * natural_speed_m_s(diameter_m, natural_gravity_m_s2(length(settings.gravity_m_s2)));
}

// More than gravity adds within a substep, or resting contacts would bounce for ever; without gravity, so slow that a body takes minutes
// for its own diameter.
double min_bounce_speed_m_s(const Settings& settings, double substep_s, double diameter_m) {
    constexpr double kShare = 0.05 / 3.132, kSubstepsOfGravity = 2, kDiametersASubstep = 1e-5;
    if (settings.solver.min_bounce_speed_m_s > 0) return settings.solver.min_bounce_speed_m_s;
    const double gravity = length(settings.gravity_m_s2);
    return std::max({kShare * natural_speed_m_s(diameter_m, gravity), kSubstepsOfGravity * gravity * substep_s,
                     kDiametersASubstep * diameter_m / substep_s});
}

}  // namespace

SolverSettings SolverSettings::pgs20() {
    SolverSettings settings;
    settings.mode = SolverMode::Pgs;
    settings.sweeps = 20;
    settings.inner_sweeps = 1;
    return settings;
}

// Soft contacts as in E. Catto's "Solver2D" (2024): a spring of the given frequency and damping ratio, solved implicitly.
Rules rules_for(const Settings& settings, const StepTimes& times, double diameter_m) {
    MELD_EXPECT(diameter_m > 0, "{} m", diameter_m);
    MELD_EXPECT(times.dt_s > 0 && times.substeps > 0, "{} s in {} substeps", times.dt_s, times.substeps);
    const SolverSettings& solver = settings.solver;
    const double h = times.substep_s();
    const auto free_speed = static_cast<float>(depenetration_speed_m_s(settings, diameter_m, kFreeShare));
    Rules rules{};
    if (solver.mode == SolverMode::Pgs) {
        rules.solve = {.apart_rate = kNeverRate,
                       .overlap_rate = static_cast<float>(solver.error_reduction / h),
                       .max_depenetration_speed = free_speed,
                       .max_latch_speed = free_speed,
                       .over_relaxation = static_cast<float>(solver.over_relaxation)};
    } else {
        // A contact that holds a load stays where b times the push equals the speed that its impulse gives.
        constexpr double kMoreThanHolds = 2;
        const double omega = 2 * std::numbers::pi * solver.stiffness_share / h;
        const double a = 2 * solver.damping_ratio + h * omega, b = h * omega * a, c = 1 / (1 + b);
        rules.solve = {.apart_rate = static_cast<float>(1 / h),
                       .overlap_rate = static_cast<float>(omega / a),
                       .max_depenetration_speed = static_cast<float>(depenetration_speed_m_s(settings, diameter_m, kUnloadedShare)),
                       .load_rate = static_cast<float>(kMoreThanHolds / b),
                       .max_latch_speed = free_speed,
                       .mass_scale = static_cast<float>(b * c),
                       .impulse_scale = static_cast<float>(c)};
    }
    rules.relax = {.apart_rate = static_cast<float>(1 / h), .overlap_rate = 0, .max_depenetration_speed = 0};
    rules.move = {.step_s = static_cast<float>(h),
                  .gravity = {static_cast<float>(settings.gravity_m_s2.x), static_cast<float>(settings.gravity_m_s2.y),
                              static_cast<float>(settings.gravity_m_s2.z)},
                  .linear_kept = static_cast<float>(1 / (1 + h * settings.linear_damping_per_s)),
                  .angular_kept = static_cast<float>(1 / (1 + h * settings.angular_damping_per_s))};
    // Gravity closes an additional gap of this size within the substep.
    rules.bounce = {.min_speed = static_cast<float>(min_bounce_speed_m_s(settings, h, diameter_m)),
                    .step_s = static_cast<float>(h),
                    .margin = static_cast<float>(h * h * length(settings.gravity_m_s2)),
                    .gravity = {rules.move.gravity[0], rules.move.gravity[1], rules.move.gravity[2]}};
    return rules;
}

Touch touch_of(BodyId body, std::uint32_t partner) {
    if (partner >= kMaxBodies) return {body, obstacle_of_code(partner), true};
    MELD_EXPECT(body != partner, "body {} touches itself", body);
    return {std::min(body, partner), std::max(body, partner), false};
}

tl::unexpected<Error> World::wrong(const std::string& problem, std::string suggestion) const {
    return fail(fmt::format("step {}: {}", tick + 1, problem), std::move(suggestion), ExitCode::LimitHit);
}

Error World::overlapping(BodyId one, BodyId other, double overlap_m) const {
    const auto [first, second] = std::minmax(one, other);
    return {fmt::format("bodies {} and {} overlap by {:.3g} m, more than {:.0f} % of their radii together", first, second, overlap_m,
                        100 * settings.max_overlap_share),
            "Move one of them away, or take a shorter step if they ran into each other"};
}

tl::unexpected<Error> World::too_deep(BodyId one, BodyId other, double overlap_m) const {
    const Error error = overlapping(one, other, overlap_m);
    return wrong(error.problem, error.suggestion);
}

Result<void> World::check_depth(BodyId body, double radius_m, std::uint32_t obstacle, double depth_m) const {
    if (!(depth_m > 2 * radius_m * settings.max_overlap_share)) return {};
    const bool moves = obstacles.moves(obstacle);
    return fail(fmt::format("body {} is {:.3g} m deep in obstacle {}, a {}{}, more than {:.0f} % of its diameter", body, depth_m, obstacle,
                            obstacles.kind(obstacle), moves ? " that moves" : "", 100 * settings.max_overlap_share),
                moves ? "Leave it room to give way, let the obstacle move more slowly, or take a shorter step"
                      : "Move it out of there, or take a shorter step if it ran into it",
                ExitCode::LimitHit);
}

Result<void> World::check_speeds() const {
    const double limit = settings.max_speed_m_s;
    const auto length_of = [](const float(&v)[3]) {
        return std::hypot(static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2]));
    };
    BodyId worst = kMaxBodies;
    for (std::uint32_t slot = 0; slot < bodies.count(); ++slot)
        if (!(std::hypot(length_of(bodies.velocity[slot].linear), length_of(bodies.velocity[slot].surface)) <= limit))
            worst = std::min(worst, bodies.properties[slot].id);
    if (worst == kMaxBodies) return {};
    const BodyVelocity& velocity = bodies.velocity[bodies.slot(worst)];
    const double speed = length_of(velocity.linear), surface = length_of(velocity.surface);
    if (!std::isfinite(speed) || !std::isfinite(surface))
        return wrong(fmt::format("the velocity of body {} is not a number", worst), "Check the forces on it, or take a shorter step");
    return wrong(fmt::format("body {} moves at {:.3g} m/s and its surface turns at {:.3g} m/s, more than max_speed_m_s = {:.3g}", worst,
                             speed, surface, limit),
                 "Take a shorter step, check the forces on it, or raise the limit");
}

void World::add_table(std::vector<Feature> features) {
    for (const Feature& feature : features) {
        feature_range = std::max(feature_range, feature.range_m);
        feature_depth = std::max(feature_depth, depth_of(feature));
        if (holds(feature.kind)) latch_range = std::max(latch_range, feature.range_m);
    }
    coils.add_table(features);
    tables.push_back(std::move(features));
}

double World::smallest_diameter_m() const { return 2 * (settings.min_radius_m > 0 ? settings.min_radius_m : radius_range(bodies).min); }

double World::least_radius_m() const {
    if (settings.least_radius_m > 0) return settings.least_radius_m;
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t slot = 0; slot < bodies.count(); ++slot) {
        const BodyProperties& what = bodies.properties[slot];
        if ((what.flags & kRemoved) != 0) continue;
        const BodyShapes::Index index = shapes.of(what.id);
        least = std::min(least, index == 0 ? bodies.place[slot].radius : shapes.kind(index).least_m);
    }
    return std::isfinite(least) ? least : 1;
}

bool World::bounces() const {
    return std::any_of(materials.begin(), materials.end(), [](const Material& material) { return material.restitution > 0; });
}

bool World::resists_turning() const { return std::any_of(materials.begin(), materials.end(), std::mem_fn(&Material::resists_turning)); }

}  // namespace meld::physics
