// ODE as the reference: the bodies mirrored as dBody and dGeom, a hash space, and dWorldQuickStep. The mirror is made when first
// needed and again when bodies or obstacles change; states are copied in when set from outside and out after every step.
#include <fmt/format.h>
#include <ode/ode.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>

#include "physics/collision/ode_library.h"
#include "physics/collision/ode_shapes.h"
#include "physics/comparison/contact_log.h"
#include "physics/comparison/engines.h"
#include "physics/comparison/ode_surface.h"
#include "physics/comparison/pairwise_features.h"
#include "physics/solver/engine.h"
#include "physics/solver/feature_wrenches.h"
#include "physics/solver/saved_bodies.h"

namespace meld::physics {

namespace {

constexpr std::size_t kMaxContactsOfPair = 4, kMaxContactsOfShapes = 8;

// A body as ODE has it, which has more digits than the world's copy.
struct SavedOdeBody {
    dReal position[3], orientation[4], velocity[3], angular_velocity[3];
};

// ODE's objects for one set of bodies and obstacles.
struct Mirror {
    dWorldID world = dWorldCreate();
    dSpaceID space = dHashSpaceCreate(nullptr);
    // Of contacts.
    dJointGroupID joints = dJointGroupCreate(0);
    std::vector<dBodyID> bodies;
    // The shapes of the bodies.
    // Of each body, one behind another; those of a compound are its parts.
    std::vector<dGeomID> forms;
    // By body: its first form.
    std::vector<std::uint32_t> first_form;
    // In the order of the world's joints; ODE keeps pointers to the forces.
    std::vector<dJointID> held;
    std::vector<dJointFeedback> held_forces;
    OdeShapes obstacles;
    // By obstacle: its first geometry.
    std::vector<std::uint32_t> first_of_obstacle;
    double damped_for_s = 0;

    Mirror() = default;
    Mirror(const Mirror&) = delete;
    Mirror& operator=(const Mirror&) = delete;
    ~Mirror() {
        dJointGroupDestroy(joints);
        for (std::size_t i = 0; i < obstacles.count(); ++i) dSpaceRemove(space, obstacles[i]);
        for (const dGeomID form : forms) dGeomDestroy(form);
        dSpaceDestroy(space);
        dWorldDestroy(world);
    }
};

class OdeEngine final : public Engine {
  public:
    explicit OdeEngine(World& world) : world_(world) {}

    Result<StepReport> step(const StepTimes& times, Workers& workers) override {
        world_.events.clear();
        drop_removed(workers);
        Bodies& bodies = world_.bodies;
        if (auto settled = world_.joints.settle(world_.movers()); !settled)
            return world_.wrong(settled.error().problem, settled.error().suggestion);
        if (bodies.count() + world_.obstacles.count() > kMaxOdeBodies)
            return fail(fmt::format("the engine 'ode' holds at most {} bodies, not {}", kMaxOdeBodies, bodies.count()),
                        "Use the engine 'blocks'");
        for (std::uint32_t slot = 0; slot < bodies.count(); ++slot)
            if (const Place& p = bodies.place[slot]; !(std::abs(p.x) + std::abs(p.y) + std::abs(p.z) < HUGE_VAL))
                return world_.wrong(fmt::format("body {} has no finite position", bodies.properties[slot].id), "Check the forces on it");
        world_.last_good = {bodies.velocity, bodies.place, bodies.orientation, true};
        {
            const StageClock clock(world_.times.actuation);
            Workers one(1);
            if (auto pulled = features_.find(world_, times.dt_s, one); !pulled) return tl::unexpected(pulled.error());
        }
        try {
            enter_ode_thread();
            if (!mirror_) build();
            if (stale_) copy_in();
            const StageClock clock(world_.times.solve);
            min_bounce_speed_ = static_cast<double>(rules_for(world_.settings, times, world_.smallest_diameter_m()).bounce.min_speed);
            // ODE shuffles contacts with random numbers of its own, which other scenes draw too.
            dRandSetSeed(seed_);
            const Vec3 gravity = world_.settings.gravity_m_s2;
            dWorldSetGravity(mirror_->world, gravity.x, gravity.y, gravity.z);
            for (int substep = 0; substep < times.substeps; ++substep) {
                const double from_s = times.start_s(world_.tick, substep), to_s = times.start_s(world_.tick, substep + 1);
                prescribe_velocities(from_s, to_s);
                prescribe_obstacles(from_s, to_s);
                step_once(times.substep_s(), substep + 1 == times.substeps);
                copy_out();
                prescribe_places(to_s);
                for (MovingFrame& frame : world_.obstacles.frames()) frame.place(to_s);
                // A body that flies away must not reach ODE's space, whose boxes would contain NaN.
                if (auto fine = world_.check_speeds(); !fine) return tl::unexpected(fine.error());
            }
        } catch (const OdeFailure& failure) {
            // ODE was interrupted halfway; its objects are abandoned and made again.
            static_cast<void>(mirror_.release());
            return world_.wrong(fmt::format("ODE gave up ({})", failure.what()),
                                "Check bodies that overlap or fly, or use the engine 'blocks'");
        }
        seed_ = dRandGetSeed();
        break_joints(times.dt_s, workers);
        if (world_.has_features()) account_charges(world_, workers);
        features_.discount(reports_);
        log_.update(world_, std::move(reports_));
        return StepReport{.bodies = bodies.count(), .awake_bodies = bodies.count(), .candidates = log_.contacts().size(), .rebuilt = true};
    }

    void structure_changed() override { mirror_.reset(), changed_ = true; }
    void body_changed(std::uint32_t, bool) override { stale_ = true; }
    void gravity_changed() override {}
    void state_restored() override {
        stale_ = true;
        world_.joints.forget_step();
    }
    void each_contact(const ContactVisitor& visit) const override {
        std::for_each(log_.contacts().begin(), log_.contacts().end(), std::cref(visit));
    }
    void add_normal_forces(std::span<ExactSum> of_slot, Workers&) const override { log_.add_normal_forces(world_.bodies, of_slot); }
    std::size_t bytes() const override { return log_.bytes(); }

    std::size_t awake_bodies() const override { return world_.bodies.count(); }
    std::vector<std::uint32_t> slots_of(Home, std::span<const std::uint32_t>) const override { return all_slots(world_.bodies); }

    // The order of the geoms in ODE's space is that of the contacts, and depends on which moved last.
    void save_home(Home, ByteWriter&, ByteWriter& contacts) const override {
        log_.save(world_.bodies, contacts);
        contacts.write(std::uint64_t{seed_});
        contacts.write(mirror_ != nullptr);
        if (!mirror_) return;
        contacts.write(stale_);
        for (const dBodyID body : mirror_->bodies) {
            SavedOdeBody saved;
            std::copy_n(dBodyGetPosition(body), 3, saved.position);
            std::copy_n(dBodyGetQuaternion(body), 4, saved.orientation);
            std::copy_n(dBodyGetLinearVel(body), 3, saved.velocity);
            std::copy_n(dBodyGetAngularVel(body), 3, saved.angular_velocity);
            contacts.write(saved);
        }
        for (int i = 0; i < dSpaceGetNumGeoms(mirror_->space); ++i) contacts.write(number_of(dSpaceGetGeom(mirror_->space, i)));
    }

    Result<void> load_home(Home, std::uint32_t, Holds, ByteReader&, ByteReader& contacts) override {
        if (!joints_fine_ || !world_.joints.fits(world_.bodies)) return damaged_snapshot("has invalid joints");
        for (const Joint& joint : world_.joints.all()) world_.composites.joined().add(joint.first, joint.second);
        if (auto loaded = log_.load(world_, contacts); !loaded) return loaded;
        changed_ = true;
        seed_ = static_cast<unsigned long>(contacts.read<std::uint64_t>());
        if (!contacts.read<bool>()) return {};
        const bool stale = contacts.read<bool>();
        enter_ode_thread();
        build();
        copy_in();
        for (const dBodyID body : mirror_->bodies) put_back(body, contacts.read<SavedOdeBody>());
        return sort_space(contacts, stale);
    }

    void save_rest(ByteWriter& out) const override { world_.joints.write(out); }
    void load_rest(ByteReader& in) override { joints_fine_ = world_.joints.read(in); }

  private:
    // What a geom of a body knows: its slot, and which part of it the geom is. Of an obstacle, its number instead.
    static void set_data(dGeomID geom, std::size_t index, std::size_t part = 0) {
        dGeomSetData(geom, reinterpret_cast<void*>(static_cast<std::uintptr_t>(std::uint64_t{part} << 32 | index)));
    }
    static std::uint32_t index_of(dGeomID geom) { return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(dGeomGetData(geom))); }
    static std::size_t part_of(dGeomID geom) { return std::uint64_t{reinterpret_cast<std::uintptr_t>(dGeomGetData(geom))} >> 32; }
    // Forms of bodies, then obstacles.
    std::uint32_t number_of(dGeomID geom) const {
        const std::uint32_t index = index_of(geom);
        return dGeomGetBody(geom) ? mirror_->first_form[index] + static_cast<std::uint32_t>(part_of(geom))
                                  : static_cast<std::uint32_t>(mirror_->forms.size() + part_of(geom)) + mirror_->first_of_obstacle[index];
    }

    // Setting a rotation would normalize it again, and change its last bits.
    static void put_back(dBodyID body, const SavedOdeBody& saved) {
        dBodySetPosition(body, saved.position[0], saved.position[1], saved.position[2]);
        auto* orientation = const_cast<dReal*>(dBodyGetQuaternion(body));
        std::copy_n(saved.orientation, 4, orientation);
        dRfromQ(const_cast<dReal*>(dBodyGetRotation(body)), orientation);
        dBodySetLinearVel(body, saved.velocity[0], saved.velocity[1], saved.velocity[2]);
        dBodySetAngularVel(body, saved.angular_velocity[0], saved.angular_velocity[1], saved.angular_velocity[2]);
    }

    // What is added last comes first.
    Result<void> sort_space(ByteReader& in, bool stale) {
        const std::size_t bodies = mirror_->forms.size();
        std::vector<std::uint32_t> order(bodies + mirror_->obstacles.count());
        for (std::uint32_t& number : order) number = in.read<std::uint32_t>();
        std::vector<std::uint32_t> sorted = order;
        std::sort(sorted.begin(), sorted.end());
        for (std::uint32_t i = 0; i < sorted.size(); ++i)
            if (sorted[i] != i) return damaged_snapshot("has other bodies in ODE's space");
        for (auto number = order.rbegin(); number != order.rend(); ++number) {
            const dGeomID geom = *number < bodies ? mirror_->forms[*number] : mirror_->obstacles[*number - bodies];
            dSpaceRemove(mirror_->space, geom);
            dSpaceAdd(mirror_->space, geom);
        }
        stale_ = stale;
        return {};
    }

    void drop_removed(Workers& workers) {
        if (!std::exchange(changed_, false)) return;
        Bodies& bodies = world_.bodies;
        std::vector<std::uint32_t> kept;
        for (std::uint32_t slot = 0; slot < bodies.count(); ++slot)
            if ((bodies.properties[slot].flags & kRemoved) == 0) kept.push_back(slot);
        if (kept.size() != bodies.count()) bodies.permute(kept, workers);
    }

    void build() {
        mirror_ = std::make_unique<Mirror>();
        const Settings& settings = world_.settings;
        const Bodies& bodies = world_.bodies;
        dWorldSetGravity(mirror_->world, settings.gravity_m_s2.x, settings.gravity_m_s2.y, settings.gravity_m_s2.z);
        dWorldSetQuickStepNumIterations(mirror_->world, settings.solver.sweeps * settings.solver.inner_sweeps);
        dWorldSetQuickStepW(mirror_->world, settings.solver.over_relaxation);
        dWorldSetERP(mirror_->world, settings.solver.error_reduction);
        for (std::uint32_t slot = 0; slot < bodies.count(); ++slot) {
            const BodyProperties& properties = bodies.properties[slot];
            const BodyShapes::Index shape = world_.shapes.of(properties.id);
            const double radius = bodies.place[slot].radius, mass = static_cast<double>(properties.mass),
                         alike = static_cast<double>(properties.inertia_factor) * radius * radius;
            const Vec3 per_kg = shape == 0 ? Vec3{alike, alike, alike} : world_.shapes.kind(shape).inertia_per_kg_m2;
            Symmetric inertia{mass * per_kg.x, 0, 0, mass * per_kg.y, 0, mass * per_kg.z};
            if (shape != 0 && world_.shapes.kind(shape).has_other_axes) inertia = turned(inertia, world_.shapes.kind(shape).axes);
            const dBodyID body = dBodyCreate(mirror_->world);
            dMass inertial;
            dMassSetParameters(&inertial, mass, 0, 0, 0, inertia.xx, inertia.yy, inertia.zz, inertia.xy, inertia.xz, inertia.yz);
            dBodySetMass(body, &inertial);
            if (properties.flags & kFixed) dBodySetKinematic(body);
            mirror_->bodies.push_back(body);
            mirror_->first_form.push_back(static_cast<std::uint32_t>(mirror_->forms.size()));
            if (shape != 0 && world_.shapes.kind(shape).shape.is_compound()) {
                add_parts(body, slot, world_.shapes.kind(shape).shape);
                continue;
            }
            const dGeomID form =
                shape == 0 ? dCreateSphere(mirror_->space, radius) : make_form(world_.shapes.kind(shape).shape, mirror_->space);
            dGeomSetBody(form, body);
            set_data(form, slot);
            mirror_->forms.push_back(form);
        }
        mirror_->held_forces.resize(world_.joints.all().size());
        for (const Joint& joint : world_.joints.all()) hold(joint);
        for (std::size_t i = 0; i < world_.obstacles.count(); ++i) {
            const std::size_t first = mirror_->obstacles.count(), parts = mirror_->obstacles.add(world_.obstacles.shape(i));
            mirror_->first_of_obstacle.push_back(static_cast<std::uint32_t>(first));
            for (std::size_t part = 0; part < parts; ++part) {
                const dGeomID geom = mirror_->obstacles[first + part];
                set_data(geom, i, part);
                dSpaceAdd(mirror_->space, geom);
            }
        }
        stale_ = true;
    }

    void add_parts(dBodyID body, std::uint32_t slot, const BodyShape& shape) {
        for (std::size_t i = 0; i < shape.parts.size(); ++i) {
            const ShapePart& part = shape.parts[i];
            const dGeomID form = make_form(solid_of(part), mirror_->space);
            const dQuaternion turn = {part.turn.w, part.turn.x, part.turn.y, part.turn.z};
            dGeomSetBody(form, body);
            dGeomSetOffsetPosition(form, part.at_m.x, part.at_m.y, part.at_m.z);
            dGeomSetOffsetQuaternion(form, turn);
            set_data(form, slot, i);
            mirror_->forms.push_back(form);
        }
    }

    static void put(dBodyID body, Vec3 place, Quat turn) {
        const dQuaternion q = {turn.w, turn.x, turn.y, turn.z};
        dBodySetPosition(body, place.x, place.y, place.z);
        dBodySetQuaternion(body, q);
    }
    static JointPose pose_of(dBodyID body) {
        const dReal *p = dBodyGetPosition(body), *q = dBodyGetQuaternion(body);
        return {{p[0], p[1], p[2]}, {q[0], q[1], q[2], q[3]}};
    }

    // ODE's angles and ways begin where the two are when they are joined, so they are put there for a moment. ODE counts those of its first
    // body, as the second one sees it.
    void hold(const Joint& joint) {
        const dBodyID first = mirror_->bodies[world_.bodies.slot(joint.first)], second = mirror_->bodies[world_.bodies.slot(joint.second)];
        put(first, {}, {});
        put(second, joint.first_anchor - rotate(joint.reference, joint.second_anchor), joint.reference);
        const Vec3 &anchor = joint.first_anchor, &axis = joint.first_axis;
        dJointID held = nullptr;
        const auto attach = [&](dJointID made) {
            held = made;
            dJointAttach(held, second, first);
        };
        switch (joint.kind) {
            case JointKind::Hinge:
                attach(dJointCreateHinge(mirror_->world, nullptr));
                dJointSetHingeAnchor(held, anchor.x, anchor.y, anchor.z);
                dJointSetHingeAxis(held, axis.x, axis.y, axis.z);
                break;
            case JointKind::Slider:
                attach(dJointCreateSlider(mirror_->world, nullptr));
                dJointSetSliderAxis(held, axis.x, axis.y, axis.z);
                break;
            case JointKind::Ball:
                attach(dJointCreateBall(mirror_->world, nullptr));
                dJointSetBallAnchor(held, anchor.x, anchor.y, anchor.z);
                break;
        }
        dJointSetFeedback(held, &mirror_->held_forces[mirror_->held.size()]);
        mirror_->held.push_back(held);
        if (!joint.moves_along()) return;
        const auto set = joint.kind == JointKind::Hinge ? dJointSetHingeParam : dJointSetSliderParam;
        const auto finite = [](double limit) { return std::clamp(limit, -dInfinity, dInfinity); };
        set(held, dParamLoStop, finite(joint.lower));
        set(held, dParamHiStop, finite(joint.upper));
    }

    // What motors and springs do in the next substep.
    void drive_joints(double step_s) {
        for (std::size_t j = 0; j < mirror_->held.size(); ++j) {
            Joint& joint = world_.joints.each()[j];
            if (!joint.moves_along()) continue;
            joint.place = place_of(joint, pose_of(body_of(joint.first)), pose_of(body_of(joint.second)));
            const JointTask task = task_of(joint, step_s);
            const auto set = joint.kind == JointKind::Hinge ? dJointSetHingeParam : dJointSetSliderParam;
            set(mirror_->held[j], dParamVel, task.speed);
            set(mirror_->held[j], dParamFMax, task.most);
            if (joint.is_spring()) set(mirror_->held[j], dParamCFM, task.softness);
        }
    }
    struct JointTask {
        double speed = 0, most = 0, softness = 0;
    };
    static JointTask task_of(Joint& joint, double step_s) {
        if (joint.is_spring()) {
            // A spring and a damper whose force is that at the end of the step.
            const double softness = 1 / (step_s * joint.stiffness + joint.damping);
            return {-joint.stiffness * (joint.place - joint.rest) * softness, dInfinity, softness};
        }
        if (joint.drive == JointDrive::Kind::Coast) return {};
        if (joint.drive == JointDrive::Kind::Motor) return {joint.target, joint.strength, 0};
        if (joint.drive == JointDrive::Kind::Brake)
            joint.target = std::clamp(joint.target, joint.place - joint.give(), joint.place + joint.give());
        const double most = joint.drive == JointDrive::Kind::Servo ? joint.servo_speed : dInfinity;
        return {std::clamp((joint.target - joint.place) / std::max(joint.response_s, step_s), -most, most), joint.strength, 0};
    }
    dBodyID body_of(BodyId body) const { return mirror_->bodies[world_.bodies.slot(body)]; }

    // The arms are those before the substep, in which the forces acted.
    void note_joint_forces(double step_s, std::span<const Quat> turns) {
        for (std::size_t j = 0; j < mirror_->held.size(); ++j) {
            Joint& joint = world_.joints.each()[j];
            const dReal *f = mirror_->held_forces[j].f1, *t = mirror_->held_forces[j].t1;
            const Vec3 force{f[0], f[1], f[2]}, arm = rotate(turns[j], joint.second_anchor);
            joint.pushed = joint.pushed + step_s * force;
            joint.twisted = joint.twisted + step_s * (Vec3{t[0], t[1], t[2]} - cross(arm, force));
        }
    }

    void break_joints(double dt_s, Workers& workers) {
        world_.joints.end_step(world_.movers(), dt_s, workers);
        for (const auto& [one, other] : world_.joints.broken()) {
            world_.composites.joined().remove(one, other);
            structure_changed();
        }
    }

    void copy_in(std::uint32_t slot) {
        const Bodies& bodies = world_.bodies;
        const auto d = [](float value) { return static_cast<double>(value); };
        const dBodyID body = mirror_->bodies[slot];
        const Place& p = bodies.place[slot];
        const Orientation& t = bodies.orientation[slot];
        const BodyVelocity& m = bodies.velocity[slot];
        dBodySetPosition(body, p.x, p.y, p.z);
        const dQuaternion q = {d(t.w), d(t.x), d(t.y), d(t.z)};
        dBodySetQuaternion(body, q);
        dBodySetLinearVel(body, d(m.linear[0]), d(m.linear[1]), d(m.linear[2]));
        dBodySetAngularVel(body, d(m.surface[0]) / p.radius, d(m.surface[1]) / p.radius, d(m.surface[2]) / p.radius);
    }
    void copy_in() {
        for (std::uint32_t slot = 0; slot < world_.bodies.count(); ++slot) copy_in(slot);
        stale_ = false;
    }

    // Before a substep; after it bodies are exactly where their motions say.
    void prescribe_velocities(double from_s, double to_s) {
        if (world_.prescribed.empty()) return;
        world_.prescribed.set_velocities(world_.bodies, world_.composites, from_s, to_s);
        world_.prescribed.each_slot(world_.bodies, [&](std::uint32_t slot) { copy_in(slot); });
    }
    void prescribe_places(double time_s) {
        if (world_.prescribed.empty()) return;
        world_.prescribed.place(world_.bodies, world_.composites, time_s);
        world_.prescribed.each_slot(world_.bodies, [&](std::uint32_t slot) { copy_in(slot); });
    }

    // Before a substep.
    void prescribe_obstacles(double from_s, double to_s) {
        Obstacles& obstacles = world_.obstacles;
        for (MovingFrame& frame : obstacles.frames()) frame.place(from_s), frame.set_velocity(from_s, to_s);
        mirror_->obstacles.follow(obstacles, mirror_->first_of_obstacle);
    }

    void copy_out() {
        Bodies& bodies = world_.bodies;
        for (std::uint32_t slot = 0; slot < bodies.count(); ++slot) {
            const dReal *p = dBodyGetPosition(mirror_->bodies[slot]), *q = dBodyGetQuaternion(mirror_->bodies[slot]);
            const dReal *v = dBodyGetLinearVel(mirror_->bodies[slot]), *w = dBodyGetAngularVel(mirror_->bodies[slot]);
            Place& place = bodies.place[slot];
            place = {p[0], p[1], p[2], place.radius};
            bodies.orientation[slot] = {static_cast<float>(q[0]), static_cast<float>(q[1]), static_cast<float>(q[2]),
                                        static_cast<float>(q[3])};
            for (int i = 0; i < 3; ++i)
                bodies.velocity[slot].linear[i] = static_cast<float>(v[i]),
                bodies.velocity[slot].surface[i] = static_cast<float>(place.radius * w[i]);
        }
    }

    // ODE's bodies keep the damping that their world had when they were made, and slow ones have none unless it is set.
    void set_damping(double step_s) {
        const Settings& settings = world_.settings;
        for (const dBodyID body : mirror_->bodies) {
            dBodySetDamping(body, 1 - 1 / (1 + step_s * settings.linear_damping_per_s),
                            1 - 1 / (1 + step_s * settings.angular_damping_per_s));
            dBodySetLinearDampingThreshold(body, 0);
            dBodySetAngularDampingThreshold(body, 0);
        }
        mirror_->damped_for_s = step_s;
    }

    void step_once(double step_s, bool last) {
        const Bodies& bodies = world_.bodies;
        const auto d = [](float value) { return static_cast<double>(value); };
        for (const std::span<const Wrench> wrenches :
             {std::span<const Wrench>(bodies.wrenches), std::span<const Wrench>(features_.wrenches())})
            for (std::size_t slot = 0; slot < wrenches.size(); ++slot) {
                const Wrench& wrench = wrenches[slot];
                dBodyAddForce(mirror_->bodies[slot], d(wrench.force[0]), d(wrench.force[1]), d(wrench.force[2]));
                dBodyAddTorque(mirror_->bodies[slot], d(wrench.torque[0]), d(wrench.torque[1]), d(wrench.torque[2]));
            }
        if (mirror_->damped_for_s != step_s) set_damping(step_s);
        reports_.clear();
        feedback_.clear();
        keep_reports_ = last;
        dSpaceCollide(mirror_->space, this, [](void* self, dGeomID a, dGeomID b) { static_cast<OdeEngine*>(self)->near(a, b); });
        for (std::size_t i = 0; i < feedback_.size(); ++i) dJointSetFeedback(feedback_[i].joint, &feedback_[i].forces);
        drive_joints(step_s);
        std::vector<Quat> turns;
        for (const Joint& joint : world_.joints.all()) turns.push_back(pose_of(body_of(joint.second)).turn);
        dWorldQuickStep(mirror_->world, step_s);
        note_joint_forces(step_s, turns);
        for (std::size_t i = 0; i < reports_.size(); ++i) {
            // The force on the second body is the opposite of the first's joint force.
            const dReal* f = feedback_[i].forces.f1;
            const Vec3 on_other = -feedback_[i].sign * Vec3{f[0], f[1], f[2]};
            reports_[i].normal_force_n = dot(on_other, reports_[i].normal);
            reports_[i].friction_n = on_other - reports_[i].normal_force_n * reports_[i].normal;
        }
        dJointGroupEmpty(mirror_->joints);
    }

    // ODE's own height fields find no contact with balls that are small compared with a cell, and leak; its meshes hold from one side only.
    bool is_computed_here(std::uint32_t obstacle) const {
        const Shape& shape = world_.obstacles.shape(obstacle);
        return std::holds_alternative<Terrain>(shape) || std::holds_alternative<Mesh>(shape);
    }
    int collide_with(std::uint32_t obstacle, std::uint32_t slot, dGeomID sphere, dGeomID other,
                     std::array<dContact, kMaxContactsOfShapes>& contacts) {
        const Place& p = world_.bodies.place[slot];
        if (const BodyShapes::Index shape = world_.shapes.of(world_.bodies.properties[slot].id); shape != 0)
            return collide_shape_with(obstacle, slot, world_.shapes.kind(shape).shape, sphere, other, contacts);
        std::array<SurfaceContact, kMaxSurfaceContacts> found;
        const int count =
            std::min(world_.obstacles.collide(0, obstacle, {p.x, p.y, p.z}, p.radius, 0, found), static_cast<int>(kMaxContactsOfPair));
        for (int i = 0; i < count; ++i) {
            const SurfaceContact& surface = found[static_cast<std::size_t>(i)];
            const Vec3 at = Vec3{p.x, p.y, p.z} - (p.radius + surface.gap_m) * surface.normal;
            dContactGeom& geom = contacts[static_cast<std::size_t>(i)].geom;
            geom = {};
            geom.pos[0] = at.x, geom.pos[1] = at.y, geom.pos[2] = at.z;
            geom.normal[0] = surface.normal.x, geom.normal[1] = surface.normal.y, geom.normal[2] = surface.normal.z;
            geom.depth = -surface.gap_m;
            geom.g1 = sphere, geom.g2 = other;
        }
        return count;
    }

    int collide_shape_with(std::uint32_t obstacle, std::uint32_t slot, const BodyShape& shape, dGeomID form, dGeomID other,
                           std::array<dContact, kMaxContactsOfShapes>& contacts) {
        const PlacedSolid solid = physics::solid_of(
            shape, physics::pose_of(centre_of(world_.bodies.place[slot]), widened(world_.bodies.orientation[slot])), part_of(form));
        const Pose& pose = solid.pose;
        std::array<Manifold, kMaxSurfaceContacts> found;
        AxisHint hint = kNoAxis;
        const int parts = world_.obstacles.collide_shape(obstacle, solid.core, pose, 0, hint, found);
        int count = 0;
        for (int part = 0; part < parts; ++part) {
            const Manifold& points = found[static_cast<std::size_t>(part)];
            for (int p = 0; p < points.count && count < static_cast<int>(kMaxContactsOfShapes); ++p) {
                const ManifoldPoint& point = points.points[static_cast<std::size_t>(p)];
                const Vec3 at = pose.centre + point.at, out = -points.normal;
                dContactGeom& geom = contacts[static_cast<std::size_t>(count++)].geom;
                geom = {};
                geom.pos[0] = at.x, geom.pos[1] = at.y, geom.pos[2] = at.z;
                geom.normal[0] = out.x, geom.normal[1] = out.y, geom.normal[2] = out.z;
                geom.depth = -point.gap_m;
                geom.g1 = form, geom.g2 = other;
            }
        }
        return count;
    }

    void near(dGeomID a, dGeomID b) {
        const dBodyID body_a = dGeomGetBody(a), body_b = dGeomGetBody(b);
        if (!body_a && !body_b) return;
        if (!body_a) return near(b, a);
        const BodyProperties& first = world_.bodies.properties[index_of(a)];
        const std::uint8_t other = body_b ? world_.bodies.properties[index_of(b)].material : world_.obstacles.material(index_of(b));
        if ((first.flags & kFixed) && (!body_b || (world_.bodies.properties[index_of(b)].flags & kFixed))) return;
        if (body_b && world_.composites.joined().has(first.id, world_.bodies.properties[index_of(b)].id)) return;
        std::array<dContact, kMaxContactsOfShapes> contacts{};
        const int most = static_cast<int>(world_.shapes.empty() ? kMaxContactsOfPair : kMaxContactsOfShapes);
        const int count = !body_b && is_computed_here(index_of(b)) ? collide_with(index_of(b), index_of(a), a, b, contacts)
                                                                   : dCollide(a, b, most, &contacts[0].geom, sizeof(dContact));
        for (int i = 0; i < count; ++i) {
            dContact& contact = contacts[static_cast<std::size_t>(i)];
            contact.surface.mode = dContactApprox1;
            contact.surface.mu = std::sqrt(static_cast<double>(world_.materials[first.material].friction) *
                                           static_cast<double>(world_.materials[other].friction));
            const double restitution =
                static_cast<double>(std::max(world_.materials[first.material].restitution, world_.materials[other].restitution));
            if (restitution > 0) {
                contact.surface.mode |= dContactBounce;
                contact.surface.bounce = restitution;
                contact.surface.bounce_vel = min_bounce_speed_;
            }
            if (!body_b && (world_.obstacles.belt(index_of(b)) != 0 || world_.obstacles.moves(index_of(b)))) {
                const dReal *at = contact.geom.pos, *out = contact.geom.normal;
                move_surface(contact, world_.obstacles.velocity_at(index_of(b), {at[0], at[1], at[2]}, {out[0], out[1], out[2]}));
            }
            resist_turning(contact.surface, world_.materials[first.material], world_.materials[other]);
            const dJointID joint = dJointCreateContact(mirror_->world, mirror_->joints, &contact);
            dJointAttach(joint, body_a, body_b);
            if (!keep_reports_) continue;
            const Touch touch = body_b ? touch_of(first.id, world_.bodies.properties[index_of(b)].id) : Touch{first.id, index_of(b), true};
            const double sign = touch.body == first.id ? 1 : -1;
            // ODE's normal leads from b to a.
            reports_.push_back(
                {touch, -sign * Vec3{contact.geom.normal[0], contact.geom.normal[1], contact.geom.normal[2]}, -contact.geom.depth, 0, {}});
            feedback_.push_back({joint, sign, {}});
        }
    }

    struct Feedback {
        dJointID joint;
        double sign;
        dJointFeedback forces;
    };

    World& world_;
    std::unique_ptr<Mirror> mirror_;
    std::vector<ContactReport> reports_;
    std::vector<Feedback> feedback_;
    PairwiseFeatures features_;
    ContactLog log_;
    double min_bounce_speed_ = 0;
    unsigned long seed_ = 0;
    bool stale_ = true, changed_ = false, keep_reports_ = false, joints_fine_ = true;
};

}  // namespace

std::unique_ptr<Engine> make_ode_engine(World& world) { return std::make_unique<OdeEngine>(world); }

}  // namespace meld::physics
