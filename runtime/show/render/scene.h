// What is in a picture: catoms with their colours, strokes and notes. Unit of length: the catom diameter.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace meld::render {

using Vec = Eigen::Vector3f;

// As screens show it (sRGB).
struct Rgb {
    std::uint8_t r = 176, g = 176, b = 176;
    bool operator==(const Rgb&) const = default;
};

// How catoms look. Discs and hexagons lie flat, for lattices in the plane; rounded ones are cubes with round edges.
enum class Form : std::uint8_t { Sphere, Cube, Disc, Hexagon, Rounded };
inline constexpr std::array<std::string_view, 5> kFormNames = {"sphere", "cube", "disc", "hexagon", "rounded"};
inline std::optional<Form> form_named(std::string_view name) {
    for (std::size_t i = 0; i < kFormNames.size(); ++i)
        if (kFormNames[i] == name) return static_cast<Form>(i);
    return std::nullopt;
}

// The radius of the edges of rounded cubes.
inline constexpr float kRound = 0.13F;

// A line between two places, with a round end or an arrow's.
struct Stroke {
    Vec from = Vec::Zero(), to = Vec::Zero();
    Rgb colour = {60, 60, 60};
    float radius = 0.05F;
    bool arrow = false;
};

// Words at a place.
struct Note {
    Vec at = Vec::Zero();
    std::string text = {};
};

// Of an obstacle; seen from both sides.
using Triangle = std::array<Vec, 3>;
inline constexpr Rgb kObstacle = {205, 200, 190};

// A ball that is as bright from all sides.
struct Lamp {
    Vec at = Vec::Zero();
    float radius = 0.2F;
};
inline constexpr Rgb kLamp = {255, 198, 26};

// A body that is no sphere: a box, a cylinder or a line, all that is within a radius of it, and how it is turned.
struct RoundedBody {
    Vec core = Vec::Zero();  // Half of its edges; (radius, 0, half height): a cylinder.
    float rounding = 0.5F;
    Eigen::Quaternionf turn = Eigen::Quaternionf::Identity();
    // Which compound of the scene it is; nothing: none. Of one, this is the ball around it.
    std::optional<std::size_t> compound = {};
    float size = 1;  // Of a compound, whose parts say how large it is.
    bool is_cylinder() const { return core.x() > 0 && core.y() == 0; }
    // Half of its thickness, where that is least.
    float least() const { return (is_cylinder() ? std::min(core.x(), core.z()) : core.minCoeff()) + rounding; }
    // Half of the edges of the box around it, in its own frame.
    Vec around() const { return Vec(core.x(), is_cylinder() ? core.x() : core.y(), core.z()) + Vec::Constant(rounding); }
    float reach() const { return core.norm() + rounding; }
    // Along an axis, from its middle.
    float reach(const Vec& axis) const {
        const Vec own = turn.conjugate() * axis;
        if (is_cylinder()) return core.x() * own.head<2>().norm() + core.z() * std::abs(own.z()) + rounding;
        return own.cwiseAbs().dot(core) + rounding;
    }
};

// One of the solids that a compound consists of: its middle in the frame of the body, and what it looks like there.
struct CompoundSolid {
    Vec at = Vec::Zero();
    RoundedBody body = {};
};

struct Scene {
    Form form = Form::Sphere;
    std::vector<Vec> places = {};
    std::vector<float> diameters = {};      // Empty: all are 1.
    std::vector<RoundedBody> rounded = {};  // What bodies look like, whatever the form says; empty: as it says.
    std::vector<std::vector<CompoundSolid>> compounds = {};
    std::vector<Rgb> colours = {};  // One for each place.
    std::vector<Stroke> strokes = {};
    std::vector<Note> notes = {};
    std::vector<Note> callouts = {};  // Written beside the picture, with a line to the place.
    std::vector<Vec> ways = {};       // From a catom to its neighbours on a lattice that fills space; of no use: empty.
    std::vector<Triangle> obstacles = {};
    std::vector<Lamp> lamps = {};
    std::optional<float> ground = {};  // The height of a floor, which shows shadows only.

    // Calls f(middle, body) for what the body at a place consists of, where there are bodies that are no spheres: mostly for itself.
    template <class F>
    void each_solid(std::size_t i, const F& f) const {
        const RoundedBody& whole = rounded[i];
        if (!whole.compound) return f(places[i], whole);
        for (const CompoundSolid& part : compounds[*whole.compound]) {
            RoundedBody solid = part.body;
            solid.core *= whole.size, solid.rounding *= whole.size, solid.turn = whole.turn * part.body.turn;
            f(Vec(places[i] + whole.turn * Vec(whole.size * part.at)), solid);
        }
    }
    // How far a catom reaches along an axis of length 1, from its middle.
    float reach(std::size_t i, const Vec& axis) const {
        if (rounded.empty()) return diameter(i) / 2;
        float most = 0;
        each_solid(i, [&](const Vec& middle, const RoundedBody& body) {
            most = std::max(most, (middle - places[i]).dot(axis) + body.reach(axis));
        });
        return most;
    }
    float diameter(std::size_t i) const { return diameters.empty() ? 1.0F : diameters[i]; }
    // The radius of the ball around a catom: cubes and hexagons reach further than what they hold.
    float reach(std::size_t i) const {
        if (!rounded.empty()) return rounded[i].reach();
        constexpr float kSqrt3 = std::numbers::sqrt3_v<float>;
        constexpr std::array<float, 5> kReach = {0.5F, kSqrt3 / 2, 0.5F, 1 / kSqrt3, kSqrt3 * (0.5F - kRound) + kRound};
        return diameter(i) * kReach[static_cast<std::size_t>(form)];
    }
};

}  // namespace meld::render
