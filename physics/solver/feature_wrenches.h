// The wrenches (force and torque) that magnets, plates and latches exert on bodies, for all engines.
#pragma once

#include <functional>
#include <vector>

#include "physics/solver/engine.h"
#include "physics/solver/latches/held_place.h"

namespace meld::physics {

// Adds a force and a torque.
void add_wrench(Wrench& wrench, Vec3 force_n, Vec3 torque_nm);

// Call these in this order in each step. First: sets all wrenches to zero, adds the energy that features draw while they are on, and warms
// coils; returns the slots of the bodies whose features have changed their strength.
std::vector<std::uint32_t> begin_feature_wrenches(World& world, std::vector<Wrench>& wrenches, double dt_s, Workers& workers);
// Then, for each pair whose surfaces are nearer than the world's range, with `normal` from a to b: adds what their features do to each
// other. Returns the force of the latches that hold, N, which the wrenches do not include.
double add_feature_wrenches(World& world, std::vector<Wrench>& wrenches, std::uint32_t a, std::uint32_t b, Vec3 normal, double gap_m);
// The same for two bodies of which at least one has a shape. Each feature is where the ray in its direction leaves the surface. Calls
// hold() for each two latches that hold, which the wrenches do not include.
void add_shape_feature_wrenches(World& world, std::vector<Wrench>& wrenches, std::uint32_t a, std::uint32_t b,
                                const std::function<void(const HeldPlace&)>& hold);
// At the end of the step: adds the energy drawn by charging plates.
void account_charges(World& world, Workers& workers);

}  // namespace meld::physics
