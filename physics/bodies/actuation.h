// What a body can pull with: magnets, electrostatic plates and latches on its surface, each with a direction in the body's frame. Bodies of
// one kind share a table of features; which of them are on belongs to each body.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "physics/bodies/types.h"
#include "runtime/base/error.h"

namespace meld::physics {

enum class FeatureKind : std::uint8_t {
    // A point dipole `depth_m` below the surface, with moment strength, A m^2, along the direction (outwards, unless reversed).
    Dipole,
    // Two poles of strength, A m, the outer `depth_m` below the surface, the other `length_m` deeper. For gaps below the length.
    TwoPole,
    // A plate of area_m2 at the surface under `cover_m` of dielectric, at strength, V, when on, or -strength where reversed.
    Plate,
    // Holds with a force of up to strength, N, once it has met another latch.
    Latch,
    // A plate that holds another like a latch once the two have met, with the force of plates that touch. It has no force from afar.
    Electrode,
};

struct Feature {
    Vec3 direction{0, 0, 1};
    FeatureKind kind = FeatureKind::Dipole;
    double strength = 1;
    double depth_m = 0.05;
    double length_m = 0.1;
    double area_m2 = 0.01;
    double cover_m = 1e-4;
    double permittivity = 3;
    // Two features that face each other do not act across a wider gap; their force falls to zero there. For a latch or an electrode: the
    // widest gap that it closes.
    double range_m = 0.1;
    // Power while on, and energy of each switching on.
    double power_w = 0;
    double switching_j = 0;
    // Of an electromagnet (coils.h): the current at which it has its strength, but for saturation; 0: a permanent magnet. The strength that
    // its iron never exceeds; 0: any. What the coil warms by, and how fast it does; 0: it stays cold.
    double current_a = 0;
    double saturation = 0;
    double resistance_ohm = 0;
    double thermal_resistance_k_w = 0;
    double cooling_s = 0;
    double ambient_k = 293.15;
    // A coil that is hotter is switched off, or gets less of its current; 0: never.
    double hottest_k = 0;
    double derating_per_k = 0;
};

// Whether it holds what touches it, by the contacts.
inline bool holds(FeatureKind kind) { return kind == FeatureKind::Latch || kind == FeatureKind::Electrode; }

inline constexpr std::size_t kMaxFeatures = 32;

// How deep below the surface a feature acts, m.
double depth_of(const Feature& feature);

// Directions to the neighbours in the lattices that ensembles use: 6 (cubic), 12 (face-centred cubic), or 24 (the corners of a
// rhombicuboctahedron, a dense cover). Unit vectors.
std::vector<Vec3> feature_directions(int count);

// The table with a checked copy of the features and unit directions; the error names the feature.
Result<std::vector<Feature>> check_features(std::vector<Feature> features);

// What two features do to each other: the force on the second (the first gets the opposite), the torques about the point of each feature,
// and the energy of the arrangement.
struct Interaction {
    Vec3 force_n;
    Vec3 first_torque_nm;
    Vec3 second_torque_nm;
    double energy_j = 0;
};

// Two point dipoles, `apart_m` from the first to the second:
// F = 3 mu0 / (4 pi r^5) ((m1.r) m2 + (m2.r) m1 + (m1.m2) r - 5 (m1.r)(m2.r) r / r^2), U = -m2.B1, torques m x B.
Interaction dipoles(Vec3 first_moment, Vec3 second_moment, Vec3 apart_m);
// Two magnetic poles of strengths p, q: F = mu0 p q / (4 pi r^2), apart for equal signs.
Interaction poles(double first, double second, Vec3 apart_m);
// Two plates facing each other `gap_m` apart, `volts` between them: F = eps0 A V^2 / (2 (g + t/eps_r)^2) together,
// C = eps0 A / (g + t/eps_r), where t is the dielectric of both.
struct PlatePull {
    double force_n;
    double capacitance_f;
};
PlatePull plates(const Feature& first, const Feature& second, double volts, double gap_m);

// Two features in the world: surface points and unit directions. `signs`: whether each is reversed.
struct FeaturePose {
    Vec3 surface;
    Vec3 direction;
    double sign;
};
// The interaction about the surface points (including the torques of forces that act deeper), cut off at the smaller of the ranges: along
// the line between two dipoles, poles or plates, an attraction or repulsion falls monotonically with their distance, to 0. Plates of unlike
// polarity attract; like plates of one voltage do nothing. Features that hold, and those of different kinds, do nothing here.
// `charge_j` receives C V^2 of plates.
Interaction interact(const Feature& first, const FeaturePose& first_pose, const Feature& second, const FeaturePose& second_pose,
                     double& charge_j);

// The force, N, with which two features hold each other that have met: the smaller strength of two latches; of electrodes the force of
// plates at no gap, by the difference of their potentials, and `charge_j` receives C V^2. Of other features, and across a gap wider than
// the smaller of their ranges, 0.
double holding_force_n(const Feature& first, const FeaturePose& first_pose, const Feature& second, const FeaturePose& second_pose,
                       double& charge_j);

}  // namespace meld::physics
