// Makes the scene that a world file describes.
#include "runtime/sim/bodies/physics_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>

#include "runtime/base/assert.h"
#include "runtime/world/description/motions.h"
#include "runtime/world/description/obstacles.h"

namespace meld::sim {

namespace {

using world::FeatureOptions;
using world::ObstacleOptions;
using world::PhysicsOptions;
using world::World;

physics::Vec3 vector_of(const world::Vec3& v) { return {v[0], v[1], v[2]}; }

physics::Settings settings_of(const World& world, RadiusRange radii, bool senses_acceleration) {
    const PhysicsOptions& p = world.physics;
    physics::Settings s;
    s.engine = p.engine == "hash" ? physics::EngineKind::Hash : p.engine == "ode" ? physics::EngineKind::Ode : physics::EngineKind::Blocks;
    if (p.solver == "pgs20") s.solver = physics::SolverSettings::pgs20();
    s.gravity_m_s2 = vector_of(p.gravity);
    s.linear_damping_per_s = p.linear_damping;
    s.angular_damping_per_s = p.angular_damping;
    s.sleep_ticks = p.sleep_ticks;
    s.sleep_speed_m_s = p.sleep_speed;
    s.max_speed_m_s = p.greatest_speed;
    s.max_overlap_share = p.deepest_overlap;
    s.min_radius_m = radii.min, s.max_radius_m = radii.max, s.least_radius_m = radii.least;
    // A run ends with the first step that fails, and reports what the programs sensed before.
    s.keep_last_good = false;
    s.keep_former_velocities = senses_acceleration;
    return s;
}

physics::Feature feature_of(const FeatureOptions& o, physics::Vec3 direction) {
    static const std::pair<std::string_view, physics::FeatureKind> kinds[] = {{"dipole", physics::FeatureKind::Dipole},
                                                                              {"two-pole", physics::FeatureKind::TwoPole},
                                                                              {"plate", physics::FeatureKind::Plate},
                                                                              {"latch", physics::FeatureKind::Latch},
                                                                              {"electrode", physics::FeatureKind::Electrode}};
    physics::Feature f;
    for (const auto& [name, kind] : kinds)
        if (o.kind == name) f.kind = kind;
    f.direction = direction;
    f.strength = o.strength, f.depth_m = o.depth, f.length_m = o.length, f.area_m2 = o.area, f.cover_m = o.cover;
    f.permittivity = o.permittivity, f.range_m = o.range, f.power_w = o.power, f.switching_j = o.switching;
    f.current_a = o.current, f.saturation = o.saturation, f.resistance_ohm = o.resistance;
    f.thermal_resistance_k_w = o.thermal_resistance, f.cooling_s = o.cooling, f.ambient_k = o.ambient;
    f.hottest_k = o.hottest, f.derating_per_k = o.derating;
    return f;
}

Result<void> add_features(const World& world, PhysicsScene& out) {
    for (const FeatureOptions& options : world.physics.features) {
        std::vector<physics::Vec3> directions;
        for (const world::Vec3& d : options.directions) directions.push_back(vector_of(d));
        if (options.count > 0) directions = physics::feature_directions(options.count);
        for (const physics::Vec3 direction : directions) out.features.push_back(feature_of(options, direction));
        if (out.features.size() > physics::kMaxFeatures)
            return fail(fmt::format("{}: a catom has {} features, and the maximum is {}", options.place, out.features.size(),
                                    physics::kMaxFeatures),
                        "List fewer directions");
    }
    if (out.features.empty()) return {};
    const auto table = out.scene->add_feature_table(out.features);
    if (!table) return fail(fmt::format("{}: {}", world.physics.features[0].place, table.error().problem), table.error().suggestion);
    out.feature_table = *table;
    return {};
}

physics::Material material_of(const World& world, const Surface& s) {
    return {.friction = static_cast<float>(s.friction),
            .restitution = static_cast<float>(s.restitution),
            .rolling_m = static_cast<float>(2 * world.radius * s.rolling_friction),
            .spinning_m = static_cast<float>(2 * world.radius * s.spinning_friction)};
}

Result<void> add_obstacles(const World& world, physics::Scene& scene) {
    const PhysicsOptions& p = world.physics;
    std::vector<ObstacleOptions> all = p.obstacles;
    if (p.ground) {
        ObstacleOptions ground;
        ground.offset = *p.ground;
        ground.place = world.path + ": [motion] ground";
        all.insert(all.begin(), ground);
    }
    for (const ObstacleOptions& o : all) {
        const auto material =
            scene.add_material(material_of(world, {.friction = o.friction.value_or(p.friction),
                                                   .restitution = o.restitution.value_or(p.restitution),
                                                   .rolling_friction = o.rolling_friction.value_or(p.rolling_friction),
                                                   .spinning_friction = o.spinning_friction.value_or(p.spinning_friction)}));
        if (!material) return fail(fmt::format("{}: {}", o.place, material.error().problem), material.error().suggestion);
        const auto added = scene.add_obstacle(world::shape_of(o, 2 * world.radius, p.compounds), *material);
        if (!added) return fail(fmt::format("{}: {}", o.place, added.error().problem), added.error().suggestion);
        if (auto set = scene.set_belt(*added, vector_of(o.belt)); !set)
            return fail(fmt::format("{}: {}", o.place, set.error().problem), set.error().suggestion);
        if (!o.motion.moves()) continue;
        if (auto moved = scene.move_obstacle(*added, world::motion_of(o, 2 * world.radius)); !moved)
            return fail(fmt::format("{}: {}", o.place, moved.error().problem), moved.error().suggestion);
    }
    return {};
}

// Every `from` that is followed by a number; `and` continues a list of them.
std::string named(std::string text, std::string_view from, std::string_view to) {
    const auto digit = [&](std::size_t i) { return i < text.size() && text[i] >= '0' && text[i] <= '9'; };
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at)) {
        if (!digit(at + from.size())) {
            at += from.size();
            continue;
        }
        text.replace(at, from.size(), to);
        at += to.size();
        while (digit(at)) ++at;
        if (text.compare(at, 5, " and ") == 0 && digit(at + 5)) text.insert(at + 5, "@");
    }
    return text;
}

}  // namespace

double height_of(const World& world, physics::Vec3 place) {
    const physics::Vec3 gravity = vector_of(world.physics.gravity);
    const double strength = length(gravity);
    return strength > 0 ? -dot(gravity, place) / strength : place.z;
}

Error about_catoms(Error error) {
    for (std::string* text : {&error.problem, &error.suggestion}) {
        *text = named(named(*text, "body ", "catom @"), "bodies ", "catoms @");
        using Name = std::pair<std::string_view, std::string_view>;
        for (const auto& [setting, key] : {Name{"max_speed_m_s", "[motion] greatest_speed"}, Name{"engine Ode", "engine \"ode\""},
                                           Name{"engine Blocks", "engine \"blocks\""}})
            if (const std::size_t at = text->find(setting); at != std::string::npos) text->replace(at, setting.size(), key);
    }
    return error;
}

Result<PhysicsScene> make_physics_scene(const World& world, RadiusRange radii, bool senses_acceleration) {
    auto scene = physics::Scene::make(settings_of(world, radii, senses_acceleration));
    if (!scene) return fail(fmt::format("{}: [motion] {}", world.path, scene.error().problem), scene.error().suggestion);
    PhysicsScene out{std::move(*scene), {}, 0, physics::Settings{}.touch_share * 2 * radii.least};
    if (auto done = add_obstacles(world, *out.scene); !done) return tl::unexpected<Error>(done.error());
    if (auto done = add_features(world, out); !done) return tl::unexpected<Error>(done.error());
    return out;
}

RadiusRange both(const RadiusRange& a, const RadiusRange& b) {
    return {std::min(a.min, b.min), std::max(a.max, b.max), std::min(a.least, b.least)};
}

BodyMaker::Described BodyMaker::describe(std::uint64_t id, world::Cell cell, const world::Vec3& position) const {
    MELD_EXPECT(id < physics::kMaxBodies && id < first_placed_ + world_.placed.size(), "catom {}", id);
    const PhysicsOptions& p = world_.physics;
    Surface surface{p.friction, p.restitution, p.rolling_friction, p.spinning_friction};
    physics::BodySpec spec;
    spec.id = static_cast<physics::BodyId>(id);
    spec.position_m = to_metres(world_, position);
    spec.radius_m = world_.radius;
    spec.mass_kg = p.mass;
    spec.inertia_factor = p.inertia;
    world::BodyForm form = p.form;
    const std::optional<world::RobotPart> part = world_.robots ? world_.robots->of(id) : std::nullopt;
    std::optional<std::size_t> connected_in = part ? robot_piece(*part) : std::nullopt;
    constexpr double kUnbreakable = std::numeric_limits<double>::infinity();
    physics::BreakingLimits breaking{p.breaking_force.value_or(kUnbreakable), p.breaking_torque.value_or(kUnbreakable)};
    for (const world::CatomGroup& group : p.groups) {
        if (!group.where.contains(id, cell, position)) continue;
        spec.radius_m = group.radius.value_or(spec.radius_m);
        spec.mass_kg = group.mass.value_or(spec.mass_kg);
        spec.inertia_factor = group.inertia.value_or(spec.inertia_factor);
        spec.fixed = group.fixed.value_or(spec.fixed);
        if (group.connected)
            connected_in = *group.connected ? std::optional(static_cast<std::size_t>(&group - p.groups.data())) : std::nullopt;
        breaking = {group.breaking_force.value_or(breaking.force_n), group.breaking_torque.value_or(breaking.torque_nm)};
        if (group.velocity) spec.linear_velocity_m_s = vector_of(*group.velocity);
        if (group.spin) spec.angular_velocity_rad_s = vector_of(*group.spin);
        if (group.form) form = *group.form;
        if (group.turned) spec.orientation = turned_by({}, (std::numbers::pi / 180) * vector_of(*group.turned));
        surface.friction = group.friction.value_or(surface.friction);
        surface.restitution = group.restitution.value_or(surface.restitution);
        surface.rolling_friction = group.rolling_friction.value_or(surface.rolling_friction);
        surface.spinning_friction = group.spinning_friction.value_or(surface.spinning_friction);
    }
    if (const world::Turn* turn = part ? world_.robots->turn_of(*part) : nullptr)
        spec.orientation = unit(product({(*turn)[0], (*turn)[1], (*turn)[2], (*turn)[3]}, spec.orientation));
    if (id >= first_placed_) {
        const world::PlacedCatom& placed = world_.placed[id - first_placed_];
        spec.radius_m = placed.radius.value_or(spec.radius_m);
        spec.mass_kg = placed.mass.value_or(spec.mass_kg);
    }
    if (form.compound) {
        spec.shape = compounds_[*form.compound];
    } else if (!form.is_sphere()) {
        const double diameter_m = 2 * world_.radius;
        const world::BodyForm::Core core = form.core(spec.radius_m / diameter_m);
        spec.shape = physics::BodyShape{diameter_m * vector_of(core.half), diameter_m * core.rounding};
    }
    std::optional<std::uint32_t> mover;
    for (std::uint32_t i = 0; i < p.movers.size(); ++i)
        if (p.movers[i].where.contains(id, cell, position)) mover = i;
    if (mover) spec.fixed = true, spec.linear_velocity_m_s = spec.angular_velocity_rad_s = {};
    return {spec, surface, connected_in, breaking, mover};
}

std::optional<std::size_t> BodyMaker::robot_piece(const world::RobotPart& part) const {
    if (!world_.robots->assemblies()[part.assembly].connects(part.part)) return std::nullopt;
    return world_.physics.groups.size() + part.robot;
}

void BodyMaker::look_at(std::uint64_t id, world::Cell cell, const world::Vec3& position) {
    const auto [spec, surface, connected_in, breaking, mover] = describe(id, cell, position);
    for (std::size_t i = 0; i < movers_met_.size(); ++i)
        if (!movers_met_[i]) movers_met_[i] = world_.physics.movers[i].where.contains(id, cell, position);
    if (mover) moved_.push_back({spec.id, *mover, {spec.position_m, spec.orientation}});
    for (std::size_t i = 0; i < groups_met_.size(); ++i)
        if (!groups_met_[i]) groups_met_[i] = world_.physics.groups[i].where.contains(id, cell, position);
    const double r = spec.shape ? spec.shape->radius_m() : spec.radius_m;
    const RadiusRange own{r, r, spec.shape ? spec.shape->least_m() : r};
    radii_ = surfaces_.empty() ? own : both(radii_, own);
    surfaces_.insert(surface);
    const double height = height_of(world_, spec.position_m);
    heights_ = {std::min(heights_.low, height), std::max(heights_.high, height)};
    if (connected_in) connected_in_.emplace(id, *connected_in);
    const bool at_rest = spec.fixed && !mover && spec.linear_velocity_m_s == physics::Vec3{};
    const FixedBody body{spec.id, spec.position_m, r, spec.shape.value_or(physics::BodyShape{{}, r}), spec.orientation};
    if (at_rest || connected_in) unwatched_.push_back(body);
    for (auto& [joint, bodies] : joined_in_)
        if (world_.physics.joints[joint].where.contains(id, cell, position)) bodies.push_back(body);
}

Result<void> add_movers(const World& world, PhysicsScene& scene, std::span<const MovedCatom> catoms) {
    for (const world::MoverOptions& mover : world.physics.movers)
        if (auto added = scene.scene->add_motion(world::motion_of(mover, 2 * world.radius)); !added)
            return fail(fmt::format("{}: {}", mover.swing.place, added.error().problem), added.error().suggestion);
    for (const MovedCatom& catom : catoms)
        if (auto done = scene.scene->prescribe(catom.body, catom.mover, catom.start); !done) return done;
    return {};
}

Result<std::map<Surface, std::uint8_t>> add_materials(const World& world, PhysicsScene& scene, const std::set<Surface>& surfaces) {
    std::map<Surface, std::uint8_t> materials;
    for (const Surface& s : surfaces) {
        const auto made = scene.scene->add_material(material_of(world, s));
        if (!made) return tl::unexpected<Error>(made.error());
        materials[s] = *made;
    }
    return materials;
}

Result<void> BodyMaker::add_materials(PhysicsScene& scene, const std::set<Surface>& surfaces) {
    auto added = sim::add_materials(world_, scene, surfaces);
    if (!added) return tl::unexpected<Error>(added.error());
    materials_ = std::move(*added);
    return {};
}

world::RoundedBody BodyMaker::looks(std::uint64_t id, world::Cell cell, const world::Vec3& position) const {
    const physics::BodySpec spec = describe(id, cell, position).spec;
    return world::look_of(spec.shape.value_or(physics::BodyShape{{}, spec.radius_m}), spec.orientation, 2 * world_.radius);
}

Result<void> BodyMaker::make(PhysicsScene& scene, std::uint64_t id, world::Cell cell, const world::Vec3& position, bool here) const {
    auto [spec, surface, connected_in, breaking, mover] = describe(id, cell, position);
    MELD_EXPECT(materials_.contains(surface), "catom {} was not looked at", id);
    spec.material = materials_.at(surface);
    if (auto added = here ? scene.scene->add_body(spec) : scene.scene->add_ghost(spec); !added) return added;
    // Where bodies cannot be connected, limits mean nothing.
    if (breaking != physics::BreakingLimits{})
        if (auto set = scene.scene->set_breaking(spec.id, breaking); !set) return set;
    if (scene.features.empty()) return {};
    return scene.scene->set_feature_table(spec.id, scene.feature_table);
}

}  // namespace meld::sim
