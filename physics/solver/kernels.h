// The loops that take most of the time, over batches of contacts and ranges of bodies. Each is one pass in the given order; kernels of
// different blocks of one colour may run at the same time.
#pragma once

#include <cstdint>
#include <span>

#include "physics/bodies/bodies.h"
#include "physics/bodies/lanes.h"
#include "physics/bodies/stage.h"
#include "physics/solver/contacts.h"

namespace meld::physics {

// Computes normal and gap of each lane from the bodies' positions; turns friction impulses into the new tangent plane. Returns whether some
// pair overlaps by more than `max_overlap` times the sum of its radii.
bool refresh_pairs(std::span<Batch> batches, const Place* places, float max_overlap);

// Applies the warm-start impulses to the bodies.
void warm_start(std::span<const Batch> batches, BodyVelocity* velocities);

// One Gauss-Seidel sweep: normal impulse, then friction, batch after batch.
void sweep(std::span<Batch> batches, BodyVelocity* velocities, const SweepRule& rule);

// The same with latches: lane i's normal impulse may go down to -adhesion[i] * step_s, and friction counts it from there.
void sweep_adhesive(std::span<Batch> batches, const Lanes* adhesion, float step_s, BodyVelocity* velocities, const SweepRule& rule);

// Friction against rolling and spinning, before a sweep (turning/turning_lanes.h). `beside`: one a batch; `adhesion`: as above, or null.
struct TurningLanes;
void resist_turning(std::span<const Batch> batches, TurningLanes* beside, const Lanes* adhesion, float step_s, BodyVelocity* velocities,
                    const SweepRule& rule);

// What one sweep would change if every contact saw the present velocities: the sum of squares of the changes of normal impulses, and of the
// impulses themselves.
struct SquareSums {
    double change = 0, impulse = 0;
};
SquareSums measure_residual(std::span<const Batch> batches, const BodyVelocity* velocities, const SweepRule& rule);

// Restitution, one sweep: contacts that approach each other and would touch within a substep collide at once, each with the impulse of a
// collision of two bodies, including friction. A sweep sees the velocities that earlier collisions have left, so a blow passes from body to
// body, and no collision adds energy. Clears the stored impulses of contacts that bounce.
void bounce(std::span<Batch> batches, std::span<Bounce> bounces, BodyVelocity* velocities, const BounceRule& rule);

// Sets `found` if some contact would bounce in such a sweep at the present velocities; otherwise the sweep would do nothing.
void look_for_bounces(std::span<const Batch> batches, std::span<const Bounce> bounces, const BodyVelocity* velocities,
                      const BounceRule& rule, bool& found);

// Velocities of the bodies first .. first + count - 1 under gravity and the wrenches (null: none; two sets are added).
void accelerate(BodyVelocity* velocities, const Place* places, const Wrench* first_wrench, const Wrench* second_wrench, std::uint32_t first,
                std::uint32_t count, const MoveRule& rule);

struct Moved {
    // The largest square of a body's speed, linear plus surface, m^2/s^2; infinite if some velocity is not a number.
    float speed_squared = 0;
    float drift_squared = 0;
};
// Positions, orientations and drifts, advanced by a step.
Moved move_bodies(Bodies& bodies, std::uint32_t first, std::uint32_t count, float step_s);
}  // namespace meld::physics
