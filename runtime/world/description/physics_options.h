// The options of a world with bodies, [motion] kind = "bodies": as read, in the units of the file.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "runtime/world/shapes/shape.h"

namespace meld::world {

// A magnet, plate or latch of a catom. SI units; see docs/physics.md for the meaning of each number. Lengths are for catoms of a metre and
// follow the diameter unless given.
struct FeatureOptions {
    std::string kind = "dipole";  // "dipole", "two-pole", "plate", "electrode" or "latch".
    int count = 0;                // 6, 12 or 24 directions; 0: `directions`.
    std::vector<Vec3> directions;
    double strength = 1, depth = 0.05, length = 0.1, area = 0.01, cover = 1e-4, permittivity = 3, range = 0.1, power = 0, switching = 0;
    // Of the coil of a magnet; 0: it has none.
    double current = 0, saturation = 0, resistance = 0, thermal_resistance = 0, cooling = 0, ambient = 293.15, hottest = 0, derating = 0;
    bool warms() const { return thermal_resistance > 0; }
    std::string place;  // "world.toml:12:5"
};

// A catom at a listed position.
struct PlacedCatom {
    Vec3 position{};                     // In diameters.
    std::optional<double> radius, mass;  // Metres, kg; as for other catoms if they are not listed.
};

// What a body looks like. Lengths in diameters of the world. Nothing: a sphere.
struct BodyForm {
    std::string kind = "sphere";          // "sphere", "cube", "box", "cylinder" or "capsule"; or the name of a compound.
    Vec3 edges{1, 1, 1};                  // Of a box.
    double length = 2;                    // Of a capsule or a cylinder, from end to end along its z axis.
    std::optional<double> rounding;       // The radius of edges, of a cylinder's rims too; nothing: a share of the least edge.
    std::optional<std::size_t> compound;  // Its place in PhysicsOptions::compounds.

    bool is_sphere() const { return kind == "sphere"; }
    // Of a solid of this radius in diameters: the half edges of what is rounded, and by how much; a cylinder is (radius, 0, half height).
    struct Core {
        Vec3 half{};
        double rounding = 0;
        double least() const {
            const bool cylinder = half[0] > 0 && half[1] == 0;
            return (cylinder ? std::min(half[0], half[2]) : std::min({half[0], half[1], half[2]})) + rounding;
        }
    };
    Core core(double radius) const;
};

// One of the solids of a compound; it is no compound itself. Lengths in diameters.
struct CompoundPart {
    BodyForm form;
    double diameter = 1;          // How thick a sphere, a cube, a cylinder or a capsule is.
    Vec3 at{};                    // Its middle, from the same origin as those of the others.
    Vec3 turned{};                // By the length of this vector in degrees, about it.
    std::optional<double> share;  // Of the mass, in proportion to the other parts; nothing: its volume, as of all others.
};

// A body of several solids that are held together.
struct CompoundForm {
    std::string name;
    std::vector<CompoundPart> parts;
    std::string place;
};

// Catoms that differ from the others; later groups override earlier ones.
struct CatomGroup {
    Region where;
    std::optional<double> radius;  // Metres
    std::optional<double> mass, inertia, friction, restitution;
    std::optional<double> rolling_friction, spinning_friction;  // As in PhysicsOptions.
    std::optional<bool> fixed;
    std::optional<bool> connected;                          // At the start, those of this group that touch are connected.
    std::optional<double> breaking_force, breaking_torque;  // As in PhysicsOptions.
    std::optional<Vec3> velocity;                           // At the start, m/s.
    std::optional<Vec3> spin;                               // At the start, rad/s.
    std::optional<BodyForm> form;                           // As in PhysicsOptions.
    std::optional<Vec3> turned;                             // At the start, by the length of this vector in degrees, about it.
    std::string place;
};

// A joint of two catoms, or of all catoms of a region that touch each other at the start; later ones override earlier ones. Or a kind of
// joints that programs make: then places and directions are those of the catom that asks, not of the world. Lengths in diameters and
// angles in degrees, with their speeds in m/s and rad/s.
struct JointOptions {
    std::string kind = "hinge";  // "hinge", "slider" or "ball".
    std::optional<std::array<std::uint64_t, 2>> between;
    Region where;                // If not between two.
    std::optional<Vec3> anchor;  // Nothing: on the line of the centres, divided as the radii are.
    Vec3 axis{0, 0, 1};
    std::optional<std::array<double, 2>> limits;
    double strength = 0;                    // Of the motor: a torque or a force.
    std::optional<double> speed, response;  // Of the servo.
    double stiffness = 0, damping = 0, rest = 0;
    std::optional<double> breaking_force, breaking_torque;  // What it carries at most, N and N m; nothing: anything.
    std::string drive = "coast";                            // At the start: "coast", "motor", "servo" or "brake".
    double target = 0;
    double reach = 0.05;  // Of a kind: how far apart the surfaces of the two may be.
    std::string place;
};

// Something that swings with the sine of 2 pi times frequency and time, and phase; it begins where it is without.
struct SwingOptions {
    Vec3 swing{};          // Along this vector, by its length to both sides: diameters, or for gravity m/s^2.
    Vec3 tilt{};           // About this vector, by its length in degrees to both sides.
    double frequency = 1;  // Hz
    double phase = 0;      // Degrees
    std::string place;
};

// What moves as the world says: it swings and tilts, and turns steadily.
struct PrescribedOptions {
    SwingOptions swing;
    Vec3 spin{};                // Steady, rad/s.
    std::optional<Vec3> pivot;  // In diameters; nothing: a catom turns about its own centre, and an obstacle about pivot_of().

    bool turns() const { return spin != Vec3{} || swing.tilt != Vec3{}; }
    bool moves() const { return turns() || swing.swing != Vec3{}; }
};

// An obstacle. Lengths in catom diameters.
struct ObstacleOptions {
    std::string kind = "plane";  // "plane", "box", "terrain", "mesh", "sphere", "cylinder", "capsule" or the name of a compound.
    Vec3 normal{0, 0, 1};        // For a plane; behind it is solid.
    double offset = 0;           // For a plane: of each of its points, times the normal.
    Vec3 centre{}, size{1, 1, 1};
    double degrees = 0;                        // For a box: its rotation about the z axis.
    Vec3 turned{};                             // For solids: by the length of this vector in degrees, about it.
    BodyForm form;                             // For solids but boxes, which have a size; of these the rounding.
    double diameter = 1;                       // For solids but boxes.
    double cell = 1;                           // For a terrain: the distance between two of its points.
    std::vector<std::vector<double>> heights;  // Rows along x; the first begins at `centre`.
    Shape shape;                               // For a mesh: one whose surface() is made of triangles.
    std::optional<double> friction, restitution, rolling_friction, spinning_friction;
    Vec3 belt{};  // The surface runs round about this vector, m/s.
    PrescribedOptions motion;
    std::string place;
};

// By how much a quantity must have changed before the catom's program sees the change. The speed is for catoms of a metre, as in
// PhysicsOptions.
struct SenseOptions {
    double position = 0.01;      // Diameters
    double orientation = 0.02;   // rad
    double velocity = 0.01;      // m/s
    double acceleration = 0.1;   // m/s^2
    double pressure = 0.05;      // Relative to the former value.
    double energy = 0.01;        // Relative to the former value.
    double load = 0.02;          // Relative to the former force, and to the former torque.
    double joint = 0.02;         // rad or diameters
    double joint_speed = 0.1;    // rad/s or m/s
    double gyro = 0.05;          // rad/s
    double accelerometer = 0.1;  // m/s^2
    double range = 0.01;         // Diameters
    double light = 0.02;         // Relative to the former value.
    double temperature = 0.5;    // K
};

// The standard deviations of what instruments show, for each axis.
struct NoiseOptions {
    double gyro = 0;           // rad/s
    double accelerometer = 0;  // m/s^2
};

// Range finders or light sensors of every body, each kind numbered through all tables. Lengths in diameters.
struct SensorOptions {
    std::string kind = "range";    // "range" or "light".
    std::vector<Vec3> directions;  // Unit vectors along the body's axes.
    double reach = 10;             // Of a range finder, from the body's surface.
    double noise = 0;              // Standard deviation: of ranges, or W/m^2.
    std::string place;
};

// A lamp that shines alike in all directions, or one on each catom of a region. Lengths in diameters.
struct LampOptions {
    std::optional<Vec3> position;
    Region where;                 // If it has no position: in the middle of each of these catoms.
    double power = 1;             // W
    double share = 1;             // Of the power, at the start.
    std::optional<double> reach;  // Nothing is lit that is farther away; nothing: anything is.
    std::string place;
};

// Catoms that are fixed and move as the world says, whatever touches them.
struct MoverOptions : PrescribedOptions {
    Region where;
};

// Steps, speeds and torques are for catoms of a metre and follow the size of the catoms unless given.
struct PhysicsOptions {
    std::string engine = "blocks";  // "blocks", "hash" or "ode".
    std::string solver = "soft";    // "soft" or "pgs20"; always "pgs20" except for "blocks".
    double step = 1.0 / 240;        // Seconds
    int substeps = 2;
    int steps = 1;  // In a tick.
    Vec3 gravity{0, 0, -9.81};
    double linear_damping = 0, angular_damping = 0;  // Shares per second.
    double mass = 1, inertia = 0.4, friction = 0.5, restitution = 0;
    // The radii of the patch on which surfaces press on each other, in diameters.
    double rolling_friction = 0, spinning_friction = 0;
    BodyForm form;
    std::vector<CompoundForm> compounds;
    double spacing = 1;            // Between cells at the start, in diameters.
    std::optional<double> ground;  // Height of a plane, in diameters.
    // What a connection carries at most, N and N m; nothing: anything.
    std::optional<double> breaking_force, breaking_torque;
    double roll_torque = 10;       // The maximum torque of `roll`, N m.
    int sleep_ticks = 30;          // Steps without motion until a region sleeps; 0: it never does.
    double sleep_speed = 0;        // 0: follows the size of the catoms and gravity.
    double greatest_speed = 1000;  // m/s
    // A catom lower than this, in diameters against gravity, is lost: it ends the run, or is removed.
    std::optional<double> lowest;
    std::string lost = "stop";     // "stop" or "remove".
    double deepest_overlap = 0.5;  // As a share of the sum of two radii.
    SenseOptions sense;
    NoiseOptions noise;
    std::vector<SensorOptions> sensors;
    std::vector<LampOptions> lamps;
    std::vector<FeatureOptions> features;
    std::vector<ObstacleOptions> obstacles;
    std::vector<CatomGroup> groups;
    std::vector<JointOptions> joints, joint_kinds;
    std::vector<MoverOptions> movers;  // Later ones override earlier ones.
    std::optional<SwingOptions> gravity_swing;

    // At the start, or when programs make them.
    bool has_joints() const { return !joints.empty() || !joint_kinds.empty(); }
    bool moves_obstacles() const {
        return std::ranges::any_of(obstacles, [](const ObstacleOptions& o) { return o.motion.moves(); });
    }
    bool has_belts() const {
        return std::ranges::any_of(obstacles, [](const ObstacleOptions& o) { return o.belt != Vec3{}; });
    }
    // Of any catom or obstacle.
    bool resists_turning() const {
        const auto resists = [](const auto& one) { return one.rolling_friction.value_or(0) > 0 || one.spinning_friction.value_or(0) > 0; };
        return rolling_friction > 0 || spinning_friction > 0 || std::ranges::any_of(groups, resists) ||
               std::ranges::any_of(obstacles, resists);
    }
    bool has_forms() const {
        return !form.is_sphere() || std::ranges::any_of(groups, [](const CatomGroup& g) { return g.form && !g.form->is_sphere(); });
    }
};

}  // namespace meld::world
