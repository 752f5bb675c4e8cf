// [motion] kind = "bodies" from TOML: one function per table.
#include "runtime/world/file/physics_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "runtime/base/default_time_scale.h"
#include "runtime/world/file/assembly_section.h"
#include "runtime/world/file/form_section.h"
#include "runtime/world/file/joint_section.h"
#include "runtime/world/file/motion_keys.h"
#include "runtime/world/file/mover_section.h"
#include "runtime/world/file/obstacle_section.h"

namespace meld::world {
namespace {

constexpr double kMost = std::numeric_limits<double>::max();

FeatureOptions feature_of_size(double diameter_m) {
    FeatureOptions feature;
    for (double* length_m : {&feature.depth, &feature.length, &feature.cover, &feature.range}) *length_m *= diameter_m;
    feature.area *= diameter_m * diameter_m;
    return feature;
}

// The current of an electromagnet, and what it does to iron and coil. A key that needs another one is an error without it.
void read_coil(const Section& section, FeatureOptions& feature) {
    const bool magnet = feature.kind == "dipole" || feature.kind == "two-pole";
    if (!magnet && section.has("current"))
        return section.wrong("current", fmt::format("this is a coil's, and the feature is of the kind {}", feature.kind),
                             "current is of magnets; plates have a voltage");
    const std::pair<const char*, double*> positive[] = {
        {"current", &feature.current},       {"saturation", &feature.saturation},
        {"resistance", &feature.resistance}, {"thermal_resistance", &feature.thermal_resistance},
        {"cooling", &feature.cooling},       {"ambient", &feature.ambient},
        {"hottest", &feature.hottest},       {"derating", &feature.derating}};
    for (const auto& [key, value] : positive) section.read_positive(key, *value);
    const std::pair<const char*, const char*> needs[] = {{"saturation", "current"},
                                                         {"resistance", "current"},
                                                         {"thermal_resistance", "resistance"},
                                                         {"cooling", "thermal_resistance"},
                                                         {"thermal_resistance", "cooling"},
                                                         {"ambient", "thermal_resistance"},
                                                         {"hottest", "thermal_resistance"},
                                                         {"derating", "hottest"}};
    for (const auto& [key, needed] : needs)
        if (section.has(key) && !section.has(needed))
            return section.wrong(key, fmt::format("a magnet with {} needs {} too", key, needed),
                                 fmt::format("give the magnet a {}, or take {} out", needed, key));
    if (section.has("hottest") && feature.hottest <= feature.ambient)
        section.wrong("hottest", fmt::format("the limit of {} K is not above the {} K around the coil", feature.hottest, feature.ambient),
                      "give both in kelvins");
}

void read_feature(TomlReader& reader, const toml::table& table, const FeatureOptions& defaults, FeatureOptions& feature) {
    feature = defaults;
    const Section section(
        reader, table, "[[motion.feature]]",
        {"kind", "directions", "strength", "depth", "length", "area", "cover", "permittivity", "range", "power", "switching", "current",
         "saturation", "resistance", "thermal_resistance", "cooling", "ambient", "hottest", "derating"});
    feature.place = reader.place(table.source());
    section.read_choice("kind", feature.kind, {"dipole", "two-pole", "plate", "latch", "electrode"});
    refuse_keys_of_others(section, feature.kind,
                          {{"dipole", {"strength", "depth"}},
                           {"two-pole", {"strength", "depth", "length"}},
                           {"plate", {"strength", "area", "cover", "permittivity"}},
                           {"latch", {"strength"}},
                           {"electrode", {"strength", "area", "cover", "permittivity"}}});
    const toml::node* directions = section.find("directions");
    if (directions && directions->is_integer()) {
        section.read_count("directions", feature.count, 0);
        if (feature.count != 6 && feature.count != 12 && feature.count != 24)
            section.wrong("directions", fmt::format("[[motion.feature]] directions = {} is not 6, 12 or 24", feature.count),
                          "list others as an array of [x, y, z]");
    } else {
        section.read("directions", feature.directions);
        if (feature.directions.empty())
            section.wrong("directions", "a [[motion.feature]] has no directions",
                          "write directions = 6, 12 or 24, or an array of [x, y, z]");
    }
    const std::pair<const char*, double*> positive[] = {{"strength", &feature.strength}, {"depth", &feature.depth},
                                                        {"length", &feature.length},     {"area", &feature.area},
                                                        {"cover", &feature.cover},       {"permittivity", &feature.permittivity},
                                                        {"range", &feature.range}};
    for (const auto& [key, value] : positive) section.read_positive(key, *value);
    section.read_number("power", feature.power, 0, kMost);
    section.read_number("switching", feature.switching, 0, kMost);
    read_coil(section, feature);
}

void read_group(TomlReader& reader, const toml::table& table, std::span<const CompoundForm> compounds, CatomGroup& group) {
    std::vector<std::string_view> keys = body_keys();
    keys.insert(keys.end(), {"where", "connected", "velocity", "spin"});
    const Section section(reader, table, "[[motion.catoms]]", keys);
    group.place = reader.place(table.source());
    if (auto where = section.read_region("where")) group.where = *where;
    bool connected = false;
    if (section.has("connected")) section.read("connected", connected), group.connected = connected;
    Vec3 vector{};
    if (section.has("velocity")) section.read("velocity", vector), group.velocity = vector;
    vector = {};
    if (section.has("spin")) section.read("spin", vector), group.spin = vector;
    read_body_keys(section, compounds, group);
}

void read_sense(TomlReader& reader, const toml::node* node, SenseOptions& sense) {
    if (!node) return;
    if (!node->is_table()) return reader.wrong(node->source(), "[motion] sense " + type_mismatch(*node, "a table [motion.sense]"));
    const Section section(reader, *node->as_table(), "[motion.sense]",
                          {"position", "orientation", "velocity", "acceleration", "pressure", "energy", "load", "joint", "joint_speed",
                           "gyro", "accelerometer", "range", "light", "coil"});
    const std::pair<const char*, double*> thresholds[] = {{"position", &sense.position},
                                                          {"orientation", &sense.orientation},
                                                          {"velocity", &sense.velocity},
                                                          {"acceleration", &sense.acceleration},
                                                          {"pressure", &sense.pressure},
                                                          {"energy", &sense.energy},
                                                          {"load", &sense.load},
                                                          {"joint", &sense.joint},
                                                          {"joint_speed", &sense.joint_speed},
                                                          {"gyro", &sense.gyro},
                                                          {"accelerometer", &sense.accelerometer},
                                                          {"range", &sense.range},
                                                          {"light", &sense.light},
                                                          {"coil", &sense.temperature}};
    for (const auto& [key, value] : thresholds) section.read_number(key, *value, 0, kMost);
}

void read_noise(TomlReader& reader, const toml::node* node, NoiseOptions& noise) {
    if (!node) return;
    if (!node->is_table()) return reader.wrong(node->source(), "[motion] noise " + type_mismatch(*node, "a table [motion.noise]"));
    const Section section(reader, *node->as_table(), "[motion.noise]", {"gyro", "accelerometer"});
    section.read_number("gyro", noise.gyro, 0, kMost);
    section.read_number("accelerometer", noise.accelerometer, 0, kMost);
}

void read_sensor(TomlReader& reader, const toml::table& table, SensorOptions& sensor) {
    const Section section(reader, table, "[[motion.sensor]]", {"kind", "directions", "reach", "noise"});
    sensor.place = reader.place(table.source());
    section.read_choice("kind", sensor.kind, {"range", "light"});
    refuse_keys_of_others(section, sensor.kind, {{"range", {"reach"}}, {"light", {}}});
    section.read("directions", sensor.directions);
    if (sensor.directions.empty())
        section.wrong("directions", "a [[motion.sensor]] has no directions", "write directions = [[1, 0, 0]]: along the body's own x axis");
    for (Vec3& direction : sensor.directions) {
        const double length = std::hypot(direction[0], direction[1], direction[2]);
        if (!(length > 0) || !std::isfinite(length))
            return section.wrong("directions", "a direction of a [[motion.sensor]] leads nowhere", "write one like [1, 0, 0]");
        for (double& x : direction) x /= length;
    }
    section.read_positive("reach", sensor.reach);
    section.read_number("noise", sensor.noise, 0, kMost);
}

void read_lamp(TomlReader& reader, const toml::table& table, LampOptions& lamp) {
    const Section section(reader, table, "[[motion.lamp]]", {"position", "where", "power", "share", "reach"});
    lamp.place = reader.place(table.source());
    const bool stands = section.has("position");
    if (stands == section.has("where"))
        section.wrong(stands ? "where" : "position",
                      stands ? "a [[motion.lamp]] has a position and a region" : "a [[motion.lamp]] is nowhere",
                      "write position = [0, 0, 5] for a lamp that stays there, or where = \"id == 0\" for one on each of these catoms");
    Vec3 position{};
    if (stands) section.read("position", position), lamp.position = position;
    if (auto where = section.read_region("where")) lamp.where = *where;
    section.read_positive("power", lamp.power);
    section.read_number("share", lamp.share, 0, 1);
    double reach = 1;
    if (section.has("reach")) section.read_positive("reach", reach), lamp.reach = reach;
}

// What only spheres can do or have is an error where it is written.
void check_forms(TomlReader& reader, const Section& section, const PhysicsOptions& p) {
    if (!p.has_forms()) return;
    const auto at = [&](const std::string& place, std::string problem, const char* suggestion) {
        reader.wrong(Error{fmt::format("{}: {}", place, problem), suggestion});
    };
    if (p.engine == "hash")
        section.wrong("engine", "the engine \"hash\" knows spheres alone", "write engine = \"blocks\", or take the shapes out");
    const bool no_spheres =
        !p.form.is_sphere() && std::ranges::none_of(p.groups, [](const CatomGroup& g) { return g.form && g.form->is_sphere(); });
    for (const CatomGroup& g : p.groups)
        if (no_spheres && g.inertia && !g.form)
            at(g.place, fmt::format("the inertia of a {} follows from its shape", p.form.kind), "take inertia out");
}

// The least thickness of all bodies, m.
double least_thickness(const PhysicsOptions& p, double diameter_m, double smallest_m) {
    double least = smallest_m;
    const auto look_at = [&](const BodyForm& form) {
        if (const auto thickness = thickness_of(form, p.compounds)) least = std::min(least, diameter_m * *thickness);
    };
    look_at(p.form);
    for (const CatomGroup& group : p.groups)
        if (group.form) look_at(*group.form);
    return least;
}

}  // namespace

const std::vector<std::string_view>& body_keys() {
    static const std::vector<std::string_view> kKeys = {
        "radius",           "mass",  "inertia", "breaking_force", "friction", "restitution",       "fixed", "shape", "breaking_torque",
        "rolling_friction", "edges", "length",  "rounding",       "turned",   "spinning_friction", "height"};
    return kKeys;
}

void read_body_keys(const Section& section, std::span<const CompoundForm> compounds, CatomGroup& group) {
    double value = 1;
    if (section.has("radius")) section.read_positive("radius", value), group.radius = value;
    value = 1;
    if (section.has("mass")) section.read_positive("mass", value), group.mass = value;
    value = 0.4;
    if (section.has("inertia")) section.read_number("inertia", value, 1e-6, 1), group.inertia = value;
    read_surface(section, {group.friction, group.restitution, group.rolling_friction, group.spinning_friction});
    bool fixed = false;
    if (section.has("fixed")) section.read("fixed", fixed), group.fixed = fixed;
    read_breaking(section, group.breaking_force, group.breaking_torque);
    Vec3 vector{};
    if (section.has("turned")) section.read("turned", vector), group.turned = vector;
    // Of more turns, too few digits are left to say how a body stands.
    constexpr double kMostDegrees = 1e6;
    if (!(std::hypot(vector[0], vector[1], vector[2]) <= kMostDegrees))
        section.wrong("turned", "a catom is turned by more than a million degrees", "write turned = [0, 0, 90]: about z, by 90 degrees");
    group.form = read_form(section, compounds);
    if (group.form && group.form->compound && group.radius)
        section.wrong("radius", fmt::format("the size of a {} is that of its parts", group.form->kind), "take radius out");
}

void read_physics(TomlReader& reader, const toml::table& table, double diameter_m, double smallest_m, const DescribedRobots& robots,
                  PhysicsOptions& p) {
    const Section section(reader, table, "[motion]",
                          {"kind",           "engine",          "solver",          "step",        "substeps",        "steps",
                           "gravity",        "linear_damping",  "angular_damping", "mass",        "inertia",         "friction",
                           "restitution",    "spacing",         "ground",          "roll_torque", "sleep_ticks",     "sleep_speed",
                           "greatest_speed", "deepest_overlap", "lowest",          "lost",        "sense",           "noise",
                           "sensor",         "feature",         "obstacle",        "catoms",      "breaking_force",  "rolling_friction",
                           "shape",          "edges",           "length",          "height",      "rounding",        "spinning_friction",
                           "lamp",           "compound",        "joint_kind",      "joint",       "breaking_torque", "mover",
                           "gravity_swing"});
    p.greatest_speed *= std::sqrt(diameter_m);
    p.sense.velocity *= std::sqrt(diameter_m);
    section.read_choice("engine", p.engine, {"blocks", "hash", "ode"});
    // Only blocks have soft contacts; two cold sweeps of the other engines would resolve only part of an impact.
    if (p.engine != "blocks") p.solver = "pgs20";
    section.read_choice("solver", p.solver, {"soft", "pgs20"});
    if (p.engine != "blocks" && p.solver == "soft")
        section.wrong("solver", fmt::format("the engine \"{}\" has no soft contacts", p.engine),
                      "take solver out, which means \"pgs20\" here, or write engine = \"blocks\"");
    section.read_count("substeps", p.substeps, 1);
    section.read_count("steps", p.steps, 1);
    section.read("gravity", p.gravity);
    section.read_number("linear_damping", p.linear_damping, 0, kMost);
    section.read_number("angular_damping", p.angular_damping, 0, kMost);
    section.read_positive("mass", p.mass);
    section.read_number("inertia", p.inertia, 1e-6, 1);
    read_compounds(reader, table, p.compounds);
    if (const auto form = read_form(section, p.compounds)) p.form = *form;
    section.read_number("friction", p.friction, 0, kMost);
    section.read_number("restitution", p.restitution, 0, 1);
    section.read_number("rolling_friction", p.rolling_friction, 0, kMost);
    section.read_number("spinning_friction", p.spinning_friction, 0, kMost);
    section.read_number("spacing", p.spacing, 0.9, kMost);
    double ground = 0;
    if (section.has("ground")) section.read_number("ground", ground), p.ground = ground;
    read_breaking(section, p.breaking_force, p.breaking_torque);
    p.roll_torque *= p.mass * diameter_m;
    section.read_number("roll_torque", p.roll_torque, 0, kMost);
    section.read_count("sleep_ticks", p.sleep_ticks, 0);
    section.read_number("sleep_speed", p.sleep_speed, 0, kMost);
    section.read_positive("greatest_speed", p.greatest_speed);
    section.read_positive("deepest_overlap", p.deepest_overlap);
    double lowest = 0;
    if (section.has("lowest")) section.read_number("lowest", lowest), p.lowest = lowest;
    section.read_choice("lost", p.lost, {"stop", "remove"});
    if (section.has("lost") && !p.lowest) section.wrong("lost", "no catom is lost without a lowest height", "write lowest = -100 too");
    read_sense(reader, section.find("sense"), p.sense);
    read_noise(reader, section.find("noise"), p.noise);
    each_table(reader, table, "motion", "feature",
               [&](const toml::table& t) { read_feature(reader, t, feature_of_size(diameter_m), p.features.emplace_back()); });
    read_obstacles(reader, table, "motion", Touched::Yes, p.compounds, p.obstacles);
    each_table(reader, table, "motion", "sensor", [&](const toml::table& t) { read_sensor(reader, t, p.sensors.emplace_back()); });
    each_table(reader, table, "motion", "lamp", [&](const toml::table& t) { read_lamp(reader, t, p.lamps.emplace_back()); });
    read_robots(reader, robots, p);
    each_table(reader, table, "motion", "catoms",
               [&](const toml::table& t) { read_group(reader, t, p.compounds, p.groups.emplace_back()); });
    each_table(reader, table, "motion", "joint", [&](const toml::table& t) { read_joint(reader, t, p.joints.emplace_back()); });
    each_table(reader, table, "motion", "joint_kind",
               [&](const toml::table& t) { read_joint_kind(reader, t, p.joint_kinds.emplace_back()); });
    if (!p.joint_kinds.empty() && p.engine == "ode")
        section.wrong("engine", "the engine \"ode\" makes no joints later", "write engine = \"blocks\", or take [[motion.joint_kind]] out");
    if (p.has_joints() && p.engine == "hash")
        section.wrong("engine", "the engine \"hash\" has no joints", "write engine = \"blocks\", or take the joints out");
    read_movers(reader, table, p);
    if ((!p.movers.empty() || p.has_belts()) && p.engine == "hash")
        section.wrong("engine", "the engine \"hash\" has no movers and no belts",
                      "write engine = \"blocks\", or take [[motion.mover]] and belt out");
    if (p.moves_obstacles() && p.engine == "hash")
        section.wrong("engine", "the engine \"hash\" has no obstacles that move",
                      "write engine = \"blocks\", or take swing, tilt and spin of [[motion.obstacle]] out");
    if (p.resists_turning() && p.engine == "hash")
        section.wrong("engine", "the engine \"hash\" has no friction against rolling and spinning",
                      "write engine = \"blocks\", or take rolling_friction and spinning_friction out");
    for (const CatomGroup& group : p.groups) smallest_m = std::min(smallest_m, 2 * group.radius.value_or(smallest_m / 2));
    smallest_m = least_thickness(p, diameter_m, smallest_m);
    check_forms(reader, section, p);
    p.step = natural_step_s(smallest_m, std::hypot(p.gravity[0], p.gravity[1], p.gravity[2]));
    section.read_seconds("step", p.step);
}

}  // namespace meld::world
