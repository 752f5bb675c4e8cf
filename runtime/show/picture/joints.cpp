#include "runtime/show/picture/joints.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <vector>

#include "runtime/world/shapes/joint_look.h"

namespace meld::picture {

namespace {

using render::Triangle;
using render::Vec;

constexpr std::size_t kMostJoints = 5000;
// As shares of how far the smaller catom reaches along the axis: half of a pin's length, and its radius; a rail's beyond the two, and half
// of its width; a ball's radius; an arm's radius.
constexpr float kPin = 1.2F, kPinRadius = 0.2F, kRail = 1.2F, kRailHalf = 0.12F, kBall = 0.36F, kArm = 0.1F;
// Anchors that are nearer than this to the surface need no arm.
constexpr float kNear = 1.05F;

// Two directions at right angles to a third.
std::array<Vec, 2> across(const Vec& axis) {
    const Vec one = axis.cross(std::abs(axis.z()) < 0.8F ? Vec::UnitZ() : Vec::UnitX()).normalized();
    return {one, axis.cross(one)};
}

// A bar with so many sides, closed at both ends.
void add_bar(const Vec& from, const Vec& to, float radius, int sides, std::vector<Triangle>& out) {
    if (!((to - from).norm() > 0)) return;
    const auto [u, v] = across((to - from).normalized());
    const auto corner = [&, one = u, other = v](int i) {
        const float angle = 2 * std::numbers::pi_v<float> * (static_cast<float>(i % sides) + 0.5F) / static_cast<float>(sides);
        return Vec(radius * (std::cos(angle) * one + std::sin(angle) * other));
    };
    for (int i = 0; i < sides; ++i) {
        const Vec one = corner(i), next = corner(i + 1);
        out.push_back({from + one, from + next, to + next});
        out.push_back({from + one, to + next, to + one});
        out.push_back({from, from + next, from + one});
        out.push_back({to, to + one, to + next});
    }
}

// An eighth of a ball, each triangle split into four so many times.
void add_eighth(const Vec& centre, float radius, const Triangle& corners, int splits, std::vector<Triangle>& out) {
    const auto& [a, b, c] = corners;
    if (splits == 0) {
        out.push_back({centre + radius * a, centre + radius * b, centre + radius * c});
        return;
    }
    const Vec ab = (a + b).normalized(), bc = (b + c).normalized(), ca = (c + a).normalized();
    for (const Triangle& part : {Triangle{a, ab, ca}, Triangle{ab, b, bc}, Triangle{ca, bc, c}, Triangle{ab, bc, ca}})
        add_eighth(centre, radius, part, splits - 1, out);
}

void add_ball(const Vec& centre, float radius, std::vector<Triangle>& out) {
    for (const float x : {-1.0F, 1.0F})
        for (const float y : {-1.0F, 1.0F})
            for (const float z : {-1.0F, 1.0F}) add_eighth(centre, radius, {x * Vec::UnitX(), y * Vec::UnitY(), z * Vec::UnitZ()}, 2, out);
}

// A way in a catom's own frame, as it is in the world.
Vec turned(const std::array<double, 4>& turn, const world::Vec3& way) {
    const auto [w, x, y, z] = turn;
    return (Eigen::Quaterniond(w, x, y, z).normalized() * Eigen::Vector3d(way[0], way[1], way[2])).cast<float>();
}

// A catom that a joint holds: where it is in what is drawn, and in the scene.
struct Held {
    std::size_t drawn, shown;
};

void add_joint(const world::JointLook& joint, const record::Drawn& drawn, const Held& one, const Held& other, render::Scene& scene) {
    const std::size_t first = one.shown, second = other.shown;
    const Vec a = scene.places[first] + turned(drawn.turn(one.drawn), joint.first_anchor);
    const Vec b = scene.places[second] + turned(drawn.turn(other.drawn), joint.second_anchor);
    const Vec axis = turned(drawn.turn(one.drawn), joint.axis).normalized();
    const float size = std::min(scene.reach(first, axis), scene.reach(second, axis));
    std::vector<Triangle>& out = scene.obstacles;
    switch (joint.kind) {
        case world::JointLook::Kind::Hinge:
            add_bar(b - kPin * size * axis, b + kPin * size * axis, kPinRadius * size, 12, out);
            break;
        case world::JointLook::Kind::Slider: {
            const float way = (b - a).dot(axis);
            add_bar(a + (std::min(0.0F, way) - kRail * size) * axis, a + (std::max(0.0F, way) + kRail * size) * axis,
                    kRailHalf * size * std::numbers::sqrt2_v<float>, 4, out);
            break;
        }
        case world::JointLook::Kind::Ball:
            add_ball(b, kBall * size, out);
            break;
    }
    for (const auto& [place, anchor] : {std::pair(first, a), std::pair(second, b)}) {
        const Vec centre = scene.places[place], way = anchor - centre;
        if (way.norm() > kNear * scene.reach(place, way.normalized())) add_bar(centre, anchor, kArm * size, 8, out);
    }
}

}  // namespace

void add_joints(const record::Drawn& drawn, std::span<const std::ptrdiff_t> places, render::Scene& scene) {
    if (drawn.joints.size() > kMostJoints) return;
    const auto held = [&](u64 id) -> std::optional<Held> {
        const auto at = drawn.find(id);
        if (!at || places[*at] < 0) return std::nullopt;
        return Held{*at, static_cast<std::size_t>(places[*at])};
    };
    for (const world::JointLook& joint : drawn.joints)
        if (const auto first = held(joint.first), second = held(joint.second); first && second)
            add_joint(joint, drawn, *first, *second, scene);
}

}  // namespace meld::picture
