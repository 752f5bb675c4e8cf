// Forces between magnets and plates, in double precision, by the textbook formulas.
#include "physics/bodies/actuation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace meld::physics {

namespace {

constexpr double kMu0 = 1.25663706212e-6;
constexpr double kEpsilon0 = 8.8541878128e-12;
constexpr double kMagnetic = kMu0 / (4 * std::numbers::pi);

void add(Interaction& sum, const Interaction& more) {
    sum.force_n = sum.force_n + more.force_n;
    sum.first_torque_nm = sum.first_torque_nm + more.first_torque_nm;
    sum.second_torque_nm = sum.second_torque_nm + more.second_torque_nm;
    sum.energy_j += more.energy_j;
}

// An interaction whose forces act at `first` and `second`, moved to other points: the levers lead from there to where the forces act.
Interaction moved(Interaction interaction, Vec3 first_lever, Vec3 second_lever) {
    interaction.first_torque_nm = interaction.first_torque_nm - cross(first_lever, interaction.force_n);
    interaction.second_torque_nm = interaction.second_torque_nm + cross(second_lever, interaction.force_n);
    return interaction;
}

// An interaction whose energy falls as `power` of the distance along a line, cut off smoothly at `reach`: the energy is multiplied by (1 -
// x)^2, x = (distance / reach)^power, and the force is its derivative, which along the line is the former force times 1 - x^2. So both fall
// monotonically, and energy is conserved.
Interaction ended(const Interaction& whole, Vec3 apart, double distance, double reach, int power) {
    if (!(distance < reach)) return {};
    double x = 1;
    for (int i = 0; i < power; ++i) x *= distance / reach;
    const double kept = (1 - x) * (1 - x), slope = -2 * power * x * (1 - x) / distance;
    return {kept * whole.force_n - (whole.energy_j * slope / distance) * apart, kept * whole.first_torque_nm, kept * whole.second_torque_nm,
            kept * whole.energy_j};
}

// Levers lead from the surface points to where something acts. Depths add to the reach: it ends where the surfaces of two features that
// face each other are the range apart, so nothing acts between bodies with a wider gap.
Interaction two_dipoles(const Feature& first, const FeaturePose& a, const Feature& second, const FeaturePose& b, double range) {
    const Vec3 first_lever = -first.depth_m * a.direction, second_lever = -second.depth_m * b.direction;
    const Vec3 apart = (b.surface + second_lever) - (a.surface + first_lever);
    const Interaction whole = dipoles((a.sign * first.strength) * a.direction, (b.sign * second.strength) * b.direction, apart);
    return moved(ended(whole, apart, length(apart), range + first.depth_m + second.depth_m, 3), first_lever, second_lever);
}

Interaction two_poles(const Feature& first, const FeaturePose& a, const Feature& second, const FeaturePose& b, double range) {
    Interaction sum;
    for (const int i : {0, 1})
        for (const int j : {0, 1}) {
            const double first_depth = first.depth_m + i * first.length_m, second_depth = second.depth_m + j * second.length_m;
            const Vec3 first_lever = -first_depth * a.direction, second_lever = -second_depth * b.direction;
            const Vec3 apart = (b.surface + second_lever) - (a.surface + first_lever);
            const double p = (i == 0 ? 1 : -1) * a.sign * first.strength, q = (j == 0 ? 1 : -1) * b.sign * second.strength;
            const Interaction whole = poles(p, q, apart);
            add(sum, moved(ended(whole, apart, length(apart), range + first_depth + second_depth, 1), first_lever, second_lever));
        }
    return sum;
}

// Plates pull along the line between their surface points, or straight on when they touch. They are separated electrically by the gap and
// the dielectric.
Interaction two_plates(const Feature& first, const FeaturePose& a, const Feature& second, const FeaturePose& b, double range,
                       double& charge_j) {
    constexpr double kTouching_m = 1e-9;
    const Vec3 between = b.surface - a.surface;
    const double gap = length(between), volts = a.sign * first.strength - b.sign * second.strength;
    const Vec3 line = gap > kTouching_m ? (1 / gap) * between : a.direction;
    const PlatePull pull = plates(first, second, volts, gap);
    const double cover = first.cover_m / first.permittivity + second.cover_m / second.permittivity;
    const Interaction whole{-pull.force_n * line, {}, {}, -pull.capacitance_f * volts * volts / 2};
    const Interaction left = ended(whole, (gap + cover) * line, gap + cover, range + cover, 1);
    charge_j = -2 * left.energy_j;
    return left;
}

}  // namespace

std::vector<Vec3> feature_directions(int count) {
    std::vector<Vec3> directions;
    const auto add_signs = [&](Vec3 v) {
        for (int signs = 0; signs < 8; ++signs) {
            const Vec3 turned{signs & 1 ? -v.x : v.x, signs & 2 ? -v.y : v.y, signs & 4 ? -v.z : v.z};
            const bool doubled = (v.x == 0 && (signs & 1)) || (v.y == 0 && (signs & 2)) || (v.z == 0 && (signs & 4));
            if (!doubled) directions.push_back((1 / length(v)) * turned);
        }
    };
    const double far = 1 + std::sqrt(2.0);
    if (count == 6)
        for (const Vec3 v : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) add_signs(v);
    if (count == 12)
        for (const Vec3 v : {Vec3{1, 1, 0}, Vec3{1, 0, 1}, Vec3{0, 1, 1}}) add_signs(v);
    if (count == 24)
        for (const Vec3 v : {Vec3{1, 1, far}, Vec3{1, far, 1}, Vec3{far, 1, 1}}) add_signs(v);
    return directions;
}

double depth_of(const Feature& feature) {
    switch (feature.kind) {
        case FeatureKind::Dipole:
            return feature.depth_m;
        case FeatureKind::TwoPole:
            return feature.depth_m + feature.length_m;
        case FeatureKind::Plate:
        case FeatureKind::Latch:
        case FeatureKind::Electrode:
            break;
    }
    return 0;
}

Result<std::vector<Feature>> check_features(std::vector<Feature> features) {
    if (features.size() > kMaxFeatures)
        return fail(fmt::format("the table has {} features, more than the {} a body can switch", features.size(), kMaxFeatures));
    for (std::size_t i = 0; i < features.size(); ++i) {
        Feature& f = features[i];
        const double norm = length(f.direction);
        if (!(norm > 0) || !std::isfinite(norm))
            return fail(fmt::format("feature {} points nowhere", i), "Give it a direction that is not zero");
        f.direction = (1 / norm) * f.direction;
        for (const double value :
             {f.strength, f.depth_m, f.length_m, f.area_m2, f.cover_m, f.permittivity, f.range_m, f.power_w, f.switching_j, f.current_a,
              f.saturation, f.resistance_ohm, f.thermal_resistance_k_w, f.cooling_s, f.ambient_k, f.hottest_k, f.derating_per_k})
            if (!std::isfinite(value) || value < 0)
                return fail(fmt::format("feature {} has the value {}", i, value),
                            "Give finite values that are not negative; which way a magnet points is switched");
        if (f.range_m == 0) return fail(fmt::format("feature {} has no range", i));
        if ((f.kind == FeatureKind::Dipole || f.kind == FeatureKind::TwoPole) && f.depth_m == 0)
            return fail(fmt::format("the magnet of feature {} lies in the surface, where its force would be infinite", i),
                        "Give it a depth");
        if (f.current_a > 0 && f.kind != FeatureKind::Dipole && f.kind != FeatureKind::TwoPole)
            return fail(fmt::format("feature {} has a current, and is no magnet", i), "Leave its current out");
        if (f.current_a > 0 && f.thermal_resistance_k_w > 0 && f.cooling_s == 0)
            return fail(fmt::format("the coil of feature {} warms in no time", i), "Give it the time constant of its cooling");
        if ((f.kind == FeatureKind::Plate || f.kind == FeatureKind::Electrode) && (f.cover_m == 0 || f.permittivity == 0))
            return fail(fmt::format("the plate of feature {} is bare, so its force would be infinite", i),
                        "Give it a cover and its permittivity");
    }
    return features;
}

Interaction dipoles(Vec3 m1, Vec3 m2, Vec3 r) {
    const double d2 = dot(r, r), d = std::sqrt(d2), d3 = d2 * d, d5 = d3 * d2;
    const double m1r = dot(m1, r), m2r = dot(m2, r);
    const Vec3 field_of_first = kMagnetic * ((3 * m1r / d5) * r - (1 / d3) * m1);
    const Vec3 field_of_second = kMagnetic * ((3 * m2r / d5) * r - (1 / d3) * m2);
    const Vec3 force = (3 * kMagnetic / d5) * (m1r * m2 + m2r * m1 + (dot(m1, m2) - 5 * m1r * m2r / d2) * r);
    return {force, cross(m1, field_of_second), cross(m2, field_of_first), -dot(m2, field_of_first)};
}

Interaction poles(double p, double q, Vec3 r) {
    const double d2 = dot(r, r), d = std::sqrt(d2);
    return {(kMagnetic * p * q / (d2 * d)) * r, {}, {}, kMagnetic * p * q / d};
}

PlatePull plates(const Feature& first, const Feature& second, double volts, double gap_m) {
    const double area = std::min(first.area_m2, second.area_m2);
    const double gap = std::max(gap_m, 0.0) + first.cover_m / first.permittivity + second.cover_m / second.permittivity;
    return {kEpsilon0 * area * volts * volts / (2 * gap * gap), kEpsilon0 * area / gap};
}

Interaction interact(const Feature& first, const FeaturePose& a, const Feature& second, const FeaturePose& b, double& charge_j) {
    charge_j = 0;
    if (first.kind != second.kind) return {};
    const double range = std::min(first.range_m, second.range_m);
    switch (first.kind) {
        case FeatureKind::Dipole:
            return two_dipoles(first, a, second, b, range);
        case FeatureKind::TwoPole:
            return two_poles(first, a, second, b, range);
        case FeatureKind::Plate:
            return two_plates(first, a, second, b, range, charge_j);
        case FeatureKind::Latch:
        case FeatureKind::Electrode:
            break;
    }
    return {};
}

double holding_force_n(const Feature& first, const FeaturePose& a, const Feature& second, const FeaturePose& b, double& charge_j) {
    charge_j = 0;
    if (first.kind != second.kind || !holds(first.kind)) return 0;
    if (!(length(b.surface - a.surface) < std::min(first.range_m, second.range_m))) return 0;
    if (first.kind == FeatureKind::Latch) return std::min(first.strength, second.strength);
    const double volts = a.sign * first.strength - b.sign * second.strength;
    const PlatePull pull = plates(first, second, volts, 0);
    charge_j = pull.capacitance_f * volts * volts;
    return pull.force_n;
}

}  // namespace meld::physics
