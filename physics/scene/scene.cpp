// The interface of scene.h: checks its arguments, keeps the world, and lets the engine step.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/comparison/engines.h"
#include "physics/scene/scene.h"
#include "physics/solver/engine.h"

namespace meld::physics {

namespace {

constexpr std::size_t kMaxMaterials = 256;
constexpr std::size_t kMaxTables = 65535;

double norm(Quat q) { return std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z); }
bool is_rotation(Quat q) { return std::isfinite(norm(q)) && std::abs(norm(q) - 1) < 1e-3; }
float single(double value) { return static_cast<float>(value); }

Result<void> check(const Settings& s) {
    const SolverSettings& solver = s.solver;
    const auto wrong = [](const char* name, double value, const char* rule) {
        return fail(fmt::format("the physics setting {} is {}", name, value), rule);
    };
    if (!is_finite(s.gravity_m_s2)) return fail("the physics setting gravity is not a number");
    if (solver.sweeps < 1) return wrong("sweeps", solver.sweeps, "Sweep at least once");
    if (solver.inner_sweeps < 1) return wrong("inner_sweeps", solver.inner_sweeps, "Sweep at least once");
    if (solver.relax_sweeps < 0) return wrong("relax_sweeps", solver.relax_sweeps, "Give a count");
    if (!(solver.over_relaxation > 0 && solver.over_relaxation < 2))
        return wrong("over_relaxation", solver.over_relaxation, "Sweeps converge between 0 and 2 only");
    if (!(solver.error_reduction >= 0 && solver.error_reduction <= 1))
        return wrong("error_reduction", solver.error_reduction, "Give a share between 0 and 1");
    if (!(solver.stiffness_share > 0 && solver.stiffness_share <= 1))
        return wrong("stiffness_share", solver.stiffness_share, "Give a share of the substep rate, up to 1");
    if (!(s.skin_share > 0 && s.skin_share <= 1))
        return wrong("skin_share", s.skin_share, "Give a share of the diameter, more than 0 and at most 1");
    if (!(s.touch_share >= 0 && s.separation_share >= s.touch_share))
        return wrong("separation_share", s.separation_share,
                     "A touch must end at a gap at least as wide as touch_share, at which it begins");
    if (!(s.separation_share <= s.skin_share))
        return wrong("separation_share", s.separation_share, "A touch must end within the skin; make skin_share larger");
    if (s.sleep_ticks < 0) return wrong("sleep_ticks", s.sleep_ticks, "Give a number of ticks, or 0 for no sleep");
    const std::pair<const char*, double> positive[] = {
        {"damping_ratio", solver.damping_ratio}, {"max_speed_m_s", s.max_speed_m_s}, {"max_overlap_share", s.max_overlap_share}};
    for (const auto& [name, value] : positive)
        if (!(value > 0) || !std::isfinite(value)) return wrong(name, value, "Give a positive number");
    const std::pair<const char*, double> not_negative[] = {{"linear_damping_per_s", s.linear_damping_per_s},
                                                           {"angular_damping_per_s", s.angular_damping_per_s},
                                                           {"max_depenetration_speed_m_s", solver.max_depenetration_speed_m_s},
                                                           {"min_bounce_speed_m_s", solver.min_bounce_speed_m_s},
                                                           {"sleep_speed_m_s", s.sleep_speed_m_s}};
    for (const auto& [name, value] : not_negative)
        if (!(value >= 0) || !std::isfinite(value)) return wrong(name, value, "Give a number that is not negative");
    return {};
}

Result<void> check(BodyId id, const BodyState& state) {
    if (!is_finite(state.position_m))
        return fail(fmt::format("body {} is at ({}, {}, {})", id, state.position_m.x, state.position_m.y, state.position_m.z),
                    "Give it a finite position");
    if (!is_rotation(state.orientation))
        return fail(fmt::format("the orientation of body {} is no rotation", id), "Give it a quaternion of length 1");
    if (!is_finite(state.linear_velocity_m_s) || !is_finite(state.angular_velocity_rad_s))
        return fail(fmt::format("the velocity of body {} is not finite", id), "Give it finite velocities");
    return {};
}

Result<void> check(const BodySpec& spec) {
    if (spec.id >= kMaxBodies)
        return fail(fmt::format("body {} has a number that is too large", spec.id), fmt::format("Number bodies below {}", kMaxBodies));
    const auto positive = [](double value) {
        return value > 0 && std::isfinite(value) && std::isfinite(single(1 / value)) && single(value) > 0;
    };
    if (!positive(spec.radius_m))
        return fail(fmt::format("body {} has the radius {} m", spec.id, spec.radius_m), "Give it a positive radius");
    if (!positive(spec.mass_kg))
        return fail(fmt::format("body {} has the mass {} kg", spec.id, spec.mass_kg), "Give it a positive mass, or make it fixed");
    if (!(spec.inertia_factor > 0 && spec.inertia_factor <= 1))
        return fail(fmt::format("body {} has the inertia factor {}", spec.id, spec.inertia_factor),
                    "Give it one in (0, 1]; 0.4 is a solid ball");
    return check(spec.id, {spec.position_m, spec.orientation, spec.linear_velocity_m_s, spec.angular_velocity_rad_s});
}

// Whether something may move so with an engine.
Result<void> check(const PrescribedMotion& motion, EngineKind engine) {
    const Vec3 vectors[] = {motion.swing_m, motion.tilt_rad, motion.spin_rad_s, motion.pivot_m.value_or(Vec3{})};
    if (!std::ranges::all_of(vectors, is_finite) || !(motion.frequency_hz >= 0) || !std::isfinite(motion.frequency_hz + motion.phase_rad))
        return fail("a prescribed motion has numbers that are not finite, or a frequency below 0", "Give other numbers");
    if (engine == EngineKind::Hash) return fail("the engine Hash has no prescribed motions", "Use the engine Blocks or Ode");
    return {};
}

BodyVelocity motion_of(const BodyState& state, double radius) {
    const Vec3 v = state.linear_velocity_m_s, u = radius * state.angular_velocity_rad_s;
    return {{single(v.x), single(v.y), single(v.z)}, 0, {single(u.x), single(u.y), single(u.z)}, 0};
}
Orientation orientation_of(Quat q) {
    const double n = 1 / norm(q);
    return {single(n * q.w), single(n * q.x), single(n * q.y), single(n * q.z)};
}

// How a body with a shape appears to what knows spheres alone: the sphere around it, with the mean of its moments of inertia.
BodySpec with_sphere_around(const BodySpec& spec) {
    BodySpec body = spec;
    if (body.shape && body.shape->is_sphere()) body.radius_m = body.shape->rounding_m, body.shape.reset();
    if (!body.shape) return body;
    body.radius_m = body.shape->radius_m();
    const Vec3 inertia = body.shape->inertia_per_kg_m2();
    body.inertia_factor = std::min((inertia.x + inertia.y + inertia.z) / (3 * body.radius_m * body.radius_m), 1.0);
    return body;
}

std::unique_ptr<Engine> make_engine(World& world) {
    switch (world.settings.engine) {
        case EngineKind::Hash:
            return make_hash_engine(world);
        case EngineKind::Ode:
            return make_ode_engine(world);
        case EngineKind::Blocks:
            break;
    }
    return make_block_engine(world);
}

}  // namespace

Scene::Scene(const Settings& settings) : world_(std::make_unique<World>()) {
    world_->settings = settings;
    SolverSettings& solver = world_->settings.solver;
    if (settings.engine != EngineKind::Blocks && solver.mode == SolverMode::Soft)
        solver.mode = SolverMode::Pgs, solver.sweeps = SolverSettings::pgs20().sweeps;
    engine_ = make_engine(*world_);
}
Scene::~Scene() = default;

Result<std::unique_ptr<Scene>> Scene::make(const Settings& settings) {
    if (auto fine = check(settings); !fine) return tl::unexpected(fine.error());
    return std::unique_ptr<Scene>(new Scene(settings));
}

Result<std::uint8_t> Scene::add_material(Material material) {
    if (!(material.friction >= 0) || !std::isfinite(material.friction))
        return fail(fmt::format("the friction {} is no coefficient", material.friction), "Give a number that is not negative");
    if (!(material.restitution >= 0 && material.restitution <= 1))
        return fail(fmt::format("the restitution {} is no share", material.restitution), "Give a number between 0 and 1");
    for (const float radius : {material.rolling_m, material.spinning_m})
        if (!(radius >= 0) || !std::isfinite(radius))
            return fail(fmt::format("the radius {} m for friction against rolling or spinning is no length", radius),
                        "Give a number that is not negative");
    if (material.resists_turning() && world_->settings.engine == EngineKind::Hash)
        return fail("the engine Hash has no friction against rolling and spinning", "Use the engine Blocks or Ode");
    if (world_->materials.size() == kMaxMaterials) return fail(fmt::format("there are already {} materials", kMaxMaterials));
    world_->materials.push_back(material);
    engine_->structure_changed();
    return static_cast<std::uint8_t>(world_->materials.size() - 1);
}

Result<std::uint32_t> Scene::add_obstacle(Shape shape, std::uint8_t material) {
    if (material >= world_->materials.size()) return fail(fmt::format("there is no material {}", material), "Add it first");
    auto added = world_->obstacles.add(std::move(shape), material);
    if (added) engine_->structure_changed();
    return added;
}

Result<std::uint32_t> Scene::add_motion(const PrescribedMotion& motion) {
    if (auto fine = check(motion, world_->settings.engine); !fine) return tl::unexpected(fine.error());
    return world_->prescribed.add(motion);
}

Result<void> Scene::move_obstacle(std::uint32_t obstacle, const PrescribedMotion& motion) {
    if (obstacle >= world_->obstacles.count()) return fail(fmt::format("there is no obstacle {}", obstacle), "Add it first");
    if (auto fine = check(motion, world_->settings.engine); !fine) return fine;
    if (world_->obstacles.moves(obstacle)) return fail(fmt::format("obstacle {} moves already", obstacle), "Give it one motion only");
    world_->obstacles.set_motion(obstacle, motion);
    engine_->structure_changed();
    return {};
}

Result<void> Scene::prescribe(BodyId body, std::uint32_t motion, const PrescribedMotion::Place& start) {
    if (motion >= world_->prescribed.motion_count()) return fail(fmt::format("there is no motion {}", motion), "Add it first");
    if (has(body) && (world_->bodies.properties[slot(body)].flags & kFixed) == 0)
        return fail(fmt::format("body {} has a prescribed motion, but is not fixed", body), "Make it a fixed body");
    world_->prescribed.prescribe(body, motion, start);
    return {};
}

Result<void> Scene::set_belt(std::uint32_t obstacle, Vec3 belt_m_s) {
    if (obstacle >= world_->obstacles.count()) return fail(fmt::format("there is no obstacle {}", obstacle), "Add it first");
    if (!is_finite(belt_m_s)) return fail("the velocity of a belt is not finite", "Give other numbers");
    if (belt_m_s == Vec3{}) return {};
    if (world_->settings.engine == EngineKind::Hash) return fail("the engine Hash has no belts", "Use the engine Blocks or Ode");
    if (world_->obstacles.belt(obstacle) != 0) return fail(fmt::format("obstacle {} has a belt already", obstacle), "Give one only");
    world_->obstacles.set_belt(obstacle, belt_m_s);
    engine_->structure_changed();
    return {};
}

Result<void> Scene::set_gravity(Vec3 gravity_m_s2) {
    if (!is_finite(gravity_m_s2)) return fail("gravity is not finite", "Give other numbers");
    if (world_->settings.gravity_m_s2 == gravity_m_s2) return {};
    world_->settings.gravity_m_s2 = gravity_m_s2;
    engine_->gravity_changed();
    return {};
}

Vec3 Scene::gravity_m_s2() const { return world_->settings.gravity_m_s2; }

Result<std::uint16_t> Scene::add_feature_table(std::vector<Feature> features) {
    if (world_->tables.size() == kMaxTables) return fail(fmt::format("there are already {} feature tables", kMaxTables));
    auto checked = check_features(std::move(features));
    if (!checked) return tl::unexpected(checked.error());
    world_->add_table(std::move(*checked));
    return static_cast<std::uint16_t>(world_->tables.size() - 1);
}

void Scene::reserve(std::size_t bodies, std::size_t ids) { world_->bodies.reserve(bodies, ids); }

// Whether a body may have its shape here.
Result<void> Scene::check_shape(const BodySpec& spec) const {
    if (!spec.shape) return {};
    if (auto fine = physics::check(*spec.shape); !fine)
        return fail(fmt::format("body {}: {}", spec.id, fine.error().problem), fine.error().suggestion);
    if (spec.shape->is_sphere()) return {};
    if (world_->settings.engine == EngineKind::Hash)
        return fail(fmt::format("body {} has a shape (the engine Hash has none)", spec.id), "Use the engine Blocks or Ode");
    return {};
}

// How deep a body is in an obstacle where it starts.
double Scene::depth_in(std::uint32_t obstacle, const BodySpec& spec) const {
    if (!spec.shape) return world_->obstacles.depth(obstacle, spec.position_m, spec.radius_m);
    double deepest = 0;
    const Pose body = pose_of(spec.position_m, spec.orientation);
    for (std::size_t i = 0; i < spec.shape->solids(); ++i)
        deepest = std::max(deepest, depth_in(obstacle, physics::solid_of(*spec.shape, body, i)));
    return deepest;
}

double Scene::depth_in(std::uint32_t obstacle, const PlacedSolid& solid) const {
    const Core& core = solid.core;
    const Pose& pose = solid.pose;
    AxisHint hint = kNoAxis;
    double depth = 0;
    const auto note = [&](const Manifold& points) {
        for (int p = 0; p < points.count; ++p) depth = std::max(depth, -points.points[static_cast<std::size_t>(p)].gap_m);
    };
    const Obstacles& obstacles = world_->obstacles;
    for (std::size_t i = 0; !obstacles.is_surface(obstacle) && i < std::max<std::size_t>(obstacles.solids(obstacle), 1); ++i) {
        Manifold found;
        found.count = 0, hint = kNoAxis;
        obstacles.collide_solid(obstacle, i, core, pose, 0, hint, found);
        note(found);
    }
    // A mesh has no inside.
    if (!std::holds_alternative<Terrain>(obstacles.shape(obstacle))) return depth;
    std::array<Manifold, kMaxSurfaceContacts> parts;
    const int count = world_->obstacles.collide_shape(obstacle, core, pose, 0, hint, parts);
    for (int part = 0; part < count; ++part) note(parts[static_cast<std::size_t>(part)]);
    return depth;
}

Result<void> Scene::add_body(const BodySpec& given) {
    if (auto fine = check_shape(given); !fine) return fine;
    const BodySpec spec = with_sphere_around(given);
    if (auto fine = check(spec); !fine) return fine;
    if (has(spec.id)) return fail(fmt::format("there is already a body {}", spec.id), "Give each body a number of its own");
    if (spec.material >= world_->materials.size())
        return fail(fmt::format("body {} is made of material {}, which does not exist", spec.id, spec.material), "Add the material first");
    Bodies& bodies = world_->bodies;
    if (bodies.has(spec.id))
        return fail(fmt::format("body {} was removed in this tick", spec.id), "Use another number, or step before you use it again");
    for (std::uint32_t obstacle = 0; !spec.fixed && obstacle < world_->obstacles.count(); ++obstacle)
        if (auto fine =
                world_->check_depth(spec.id, spec.shape ? spec.shape->least_m() : spec.radius_m, obstacle, depth_in(obstacle, spec));
            !fine)
            return fail(fine.error().problem, fine.error().suggestion);
    const BodyProperties properties{.id = spec.id,
                                    .mass = single(spec.mass_kg),
                                    .inertia_factor = single(spec.inertia_factor),
                                    .material = spec.material,
                                    .flags = static_cast<std::uint8_t>((spec.fixed ? kFixed : 0) | (spec.shape ? kShaped : 0)),
                                    .still_ticks = 0};
    world_->shapes.forget(spec.id);
    world_->coils.forget(spec.id);
    if (spec.shape)
        if (auto set = world_->shapes.set(spec.id, *spec.shape); !set) return set;
    const BodyState state{spec.position_m, spec.orientation, spec.linear_velocity_m_s, spec.angular_velocity_rad_s};
    bodies.add({spec.position_m.x, spec.position_m.y, spec.position_m.z, spec.radius_m}, orientation_of(spec.orientation),
               motion_of(state, spec.radius_m), properties);
    bodies.restore_masses(bodies.slot(spec.id));
    engine_->structure_changed();
    return {};
}

Result<void> Scene::add_ghost(const BodySpec& spec) {
    if (auto added = add_body(spec); !added) return added;
    world_->bodies.properties[world_->bodies.slot(spec.id)].flags |= kGhost;
    return {};
}

Result<void> Scene::known(BodyId body) const {
    if (has(body)) return {};
    return fail(fmt::format("there is no body {}", body));
}

Result<void> Scene::remove_body(BodyId body) {
    if (auto fine = known(body); !fine) return fine;
    world_->composites.release_all(body);
    wake_joined(body);
    world_->joints.remove_all(body);
    world_->composites.joined().remove_all(body);
    world_->loads.remove_body(body);
    world_->bodies.properties[world_->bodies.slot(body)].flags |= kRemoved;
    engine_->body_changed(world_->bodies.slot(body), false);
    engine_->structure_changed();
    return {};
}

Result<void> Scene::set_state(BodyId body, const BodyState& state) {
    if (auto fine = known(body); !fine) return fine;
    if (auto fine = check(body, state); !fine) return fine;
    Bodies& bodies = world_->bodies;
    const std::uint32_t slot = bodies.slot(body);
    Place& place = bodies.place[slot];
    const bool shaped = (bodies.properties[slot].flags & kShaped) != 0;
    const bool moved = shaped || Vec3{place.x, place.y, place.z} != state.position_m;
    place = {state.position_m.x, state.position_m.y, state.position_m.z, place.radius};
    bodies.orientation[slot] = orientation_of(state.orientation);
    const BodyVelocity former = bodies.velocity[slot];
    bodies.velocity[slot] = motion_of(state, place.radius);
    bodies.velocity[slot].inverse_mass = former.inverse_mass, bodies.velocity[slot].inverse_surface_mass = former.inverse_surface_mass;
    world_->composites.body_moved(body);
    world_->joints.places_changed();
    engine_->body_changed(slot, moved);
    wake_joined(body);
    contacts_known_ = false;
    return {};
}

Result<void> Scene::set_wrench(BodyId body, Vec3 force, Vec3 torque) {
    if (auto fine = known(body); !fine) return fine;
    if (!is_finite(force) || !is_finite(torque))
        return fail(fmt::format("the force on body {} is not finite", body), "Give it finite forces");
    Bodies& bodies = world_->bodies;
    bodies.need_wrenches();
    const std::uint32_t slot = bodies.slot(body);
    bodies.wrenches[slot] = {{single(force.x), single(force.y), single(force.z)}, {single(torque.x), single(torque.y), single(torque.z)}};
    engine_->body_changed(slot, false);
    return {};
}

Result<void> Scene::set_feature_table(BodyId body, std::uint16_t table) {
    if (auto fine = known(body); !fine) return fine;
    if (table >= world_->tables.size()) return fail(fmt::format("there is no feature table {}", table), "Add it first");
    if (const BodyShapes::Index index = world_->shapes.of(body); index != 0) {
        const BodyShape& shape = world_->shapes.kind(index).shape;
        for (const Feature& feature : world_->tables[table]) {
            if (const Vec3 d = feature.direction; shape.way_out_m(d) == 0)
                return fail(
                    fmt::format(
                        "a magnet, plate or latch of body {} is in the direction ({:.3g}, {:.3g}, {:.3g}), where its compound has no "
                        "part (seen from its centre of mass)",
                        body, d.x, d.y, d.z),
                    "Choose directions that lead through parts");
        }
    }
    Bodies& bodies = world_->bodies;
    bodies.need_features();
    const std::uint32_t slot = bodies.slot(body);
    bodies.features[slot] = {};
    bodies.features[slot].table = table;
    world_->coils.forget(body);
    engine_->body_changed(slot, false);
    return {};
}

Result<void> Scene::set_features(BodyId body, std::uint32_t on, std::uint32_t reversed) {
    if (auto fine = known(body); !fine) return fine;
    Bodies& bodies = world_->bodies;
    bodies.need_features();
    const std::uint32_t slot = bodies.slot(body);
    Bodies::FeatureState& state = bodies.features[slot];
    const std::vector<Feature>& table = world_->tables[state.table];
    const std::uint64_t has = (std::uint64_t{1} << table.size()) - 1;
    if ((on & ~has) != 0 || (reversed & ~has) != 0)
        return fail(fmt::format("body {} has {} features, and another one is switched", body, table.size()),
                    "Switch only bits below that number");
    if (state.on == on && state.reversed == reversed) return {};
    for (std::size_t i = 0; i < table.size(); ++i)
        if ((on & ~state.on) >> i & 1) {
            bodies.energy[slot] += table[i].switching_j;
            if (is_supplied(table[i])) world_->coils.supply(table, body, i, rated_supply(table[i]));
        }
    state.on = on, state.reversed = reversed;
    engine_->body_changed(slot, false);
    return {};
}

Result<void> Scene::set_supply(BodyId body, std::size_t feature, double level) {
    if (auto fine = known(body); !fine) return fine;
    Bodies& bodies = world_->bodies;
    bodies.need_features();
    const std::uint32_t slot = bodies.slot(body);
    const std::vector<Feature>& table = world_->tables[bodies.features[slot].table];
    if (feature >= table.size() || !is_supplied(table[feature]))
        return fail(fmt::format("feature {} of body {} takes no current and no voltage", feature, body),
                    "Supply plates, and magnets with a current");
    if (!std::isfinite(level) || level < 0)
        return fail(fmt::format("feature {} of body {} is supplied with {}", feature, body, level),
                    "Give a value that is not negative; which way a magnet points is switched");
    if (world_->coils.supply(table, body, feature, level)) engine_->body_changed(slot, false);
    return {};
}

Result<StepReport> Scene::step(double dt_s, int substeps, Workers& workers) {
    contacts_known_ = false;
    if (!(dt_s > 0) || !std::isfinite(dt_s) || substeps < 1)
        return fail(fmt::format("a step of {} s in {} substeps cannot be taken", dt_s, substeps),
                    "Give a positive time and at least one substep");
    Bodies& bodies = world_->bodies;
    LastGood& kept = world_->last_good;
    kept.complete = false;
    auto report = engine_->step({dt_s, substeps}, workers);
    if (!report) {
        if (kept.complete) {
            std::copy(kept.velocity.begin(), kept.velocity.end(), bodies.velocity.begin());
            std::copy(kept.place.begin(), kept.place.end(), bodies.place.begin());
            std::copy(kept.orientation.begin(), kept.orientation.end(), bodies.orientation.begin());
            engine_->state_restored();
        }
        for (MovingFrame& frame : world_->obstacles.frames()) frame.place(StepTimes{dt_s, substeps}.start_s(world_->tick, 0));
        world_->events.clear();
        return report;
    }
    world_->last_step_s = dt_s;
    report->tick = ++world_->tick;
    return report;
}

}  // namespace meld::physics
