// How a scene is stepped: which engine and solver, and their thresholds.
#pragma once

#include <cstddef>

#include "physics/bodies/types.h"

namespace meld::physics {

enum class EngineKind {
    // The sparse grid of blocks and the coloured solver: deterministic, for millions of bodies.
    Blocks,
    // The original design, for comparison: bins filled by atomic exchange, and a parallel sweep without locks, which is not deterministic
    // with several workers.
    Hash,
    // Unmodified ODE: a hash space and dWorldQuickStep, one thread, at most kMaxOdeBodies.
    Ode,
};

enum class SolverMode {
    // Soft contacts with warm start and a relaxation sweep: stacks stand. Only Blocks has them; the other engines use the sweeps of pgs20
    // instead.
    Soft,
    // Projected Gauss-Seidel from zero, with error reduction, as in ODE's QuickStep.
    Pgs,
};

struct SolverSettings {
    SolverMode mode = SolverMode::Soft;
    // Sweeps over all colours in a substep, and how often each block is swept while it is in the cache.
    int sweeps = 2;
    int inner_sweeps = 1;
    // Soft: sweeps that remove the velocity that separated the overlaps.
    int relax_sweeps = 1;
    // Soft: the stiffness of contacts, as a share of the substep rate, and how strongly they are damped.
    double stiffness_share = 0.25;
    double damping_ratio = 10;
    // Pgs: over-relaxation, and the share of an overlap removed in a step (ODE's ERP).
    double over_relaxation = 1.3;
    double error_reduction = 0.2;
    // The maximum speed at which overlaps are resolved; 0: follows the size of the bodies, 3 m/s for a diameter of 1 m. Soft: 0.1 m/s, or
    // as fast as the load on a contact needs.
    double max_depenetration_speed_m_s = 0;
    // Contacts that approach more slowly do not bounce; 0: follows size and gravity, 0.05 m/s for a diameter of 1 m.
    double min_bounce_speed_m_s = 0;

    // What ODE does by default: 20 cold sweeps.
    static SolverSettings pgs20();
};

struct Settings {
    EngineKind engine = EngineKind::Blocks;
    SolverSettings solver = {};
    Vec3 gravity_m_s2{0, 0, -9.81};
    // The share of the velocity lost per second (in the limit of small steps).
    double linear_damping_per_s = 0;
    double angular_damping_per_s = 0;
    // Candidates are reused until something has moved half the skin, a share of the smallest body's diameter.
    double skin_share = 0.1;
    // A touch begins when the gap falls below touch_share, and ends when it exceeds separation_share; shares of the smallest diameter.
    double touch_share = 0.005;
    double separation_share = 0.02;
    // A block sleeps when it and the blocks around it have been slower than this for sleep_ticks ticks; 0 ticks: never.
    int sleep_ticks = 30;
    // 0: sleep_speed_share times the speed sqrt(gravity * smallest diameter).
    double sleep_speed_m_s = 0;
    double sleep_speed_share = 0.0016;
    // Bounds of the radii of all bodies, if a scene is part of a larger one and must divide space as all subdomains do; 0: taken from the
    // bodies.
    double min_radius_m = 0;
    double max_radius_m = 0;
    // Then also half of the least thickness of all bodies, which may be less where some have shapes.
    double least_radius_m = 0;
    // Limits beyond which a step ends with an error.
    double max_speed_m_s = 1000;
    double max_overlap_share = 0.5;
    // Copy the state before each step, to restore it if the step ends with an error (80 bytes a body).
    bool keep_last_good = true;
    // Copy the velocities before each step, from which accelerations are computed (32 bytes a body).
    bool keep_former_velocities = true;
};

inline constexpr std::size_t kMaxOdeBodies = 131072;

}  // namespace meld::physics
