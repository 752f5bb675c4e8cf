// The loops that take the time, over batches of contacts and ranges of bodies. Each is one pass in the order given; kernels of
// different blocks of one colour may run at once.
#pragma once

#include <cstdint>
#include <span>

#include "physics/bodies.h"
#include "physics/contacts.h"
#include "physics/lanes.h"
#include "physics/stage.h"

namespace meld::physics {

// Normal and gap of each lane from the bodies' places; friction impulses are turned into the new tangent plane. Returns whether
// some pair overlaps by more than `max_overlap` times the sum of its radii.
bool refresh_pairs(std::span<Batch> batches, const Place* places, float max_overlap);

// Gives the bodies the impulses kept from before.
void warm_start(std::span<const Batch> batches, BodyVelocity* velocities);

// One Gauss-Seidel sweep: normal impulse, then friction, batch after batch.
void sweep(std::span<Batch> batches, BodyVelocity* velocities, const SweepRule& rule);

// The same with latches: lane i's normal impulse may go down to -adhesion[i] * step_s, and friction sees it from there.
void sweep_adhesive(std::span<Batch> batches, const Lanes* adhesion, float step_s, BodyVelocity* velocities, const SweepRule& rule);

// What one sweep would change, if every contact saw the velocities as they are: the sum of squares of the normal impulses'
// changes, and of the impulses themselves.
struct SquareSums {
    double change = 0, impulse = 0;
};
SquareSums measure_residual(std::span<const Batch> batches, const BodyVelocity* velocities, const SweepRule& rule);

// Restitution, one sweep: contacts that approach each other and would touch within a substep collide at once, each with the
// impulse of a collision of two bodies, friction included. A sweep sees the velocities that earlier collisions have left, so a
// blow goes on from body to body, and no collision adds energy. Kept impulses of contacts that bounce are cleared.
void bounce(std::span<Batch> batches, std::span<Bounce> bounces, BodyVelocity* velocities, const BounceRule& rule);

// Sets `found` if some contact would bounce in such a sweep as velocities are now; if none would, the sweep does nothing.
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
// Places, orientations and drifts a step on.
Moved move_bodies(Bodies& bodies, std::uint32_t first, std::uint32_t count, float step_s);
}  // namespace meld::physics
