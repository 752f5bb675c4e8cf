// Restitution of bodies with shapes. All points of two bodies collide together: each is to part with the speed that its own approach
// implies, and a few rounds over the points find impulses that do so, none of which pulls. So a face that lands flat leaves flat.
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "physics/bodies/symmetric.h"
#include "physics/solver/shapes/shape_contacts.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

constexpr int kBounceRounds = 12;

// A body of a contact that collides, or the composite that it is a member of. Arms of points are turned into those that count here: in
// metres from the centre of a composite.
struct PointCollider {
    double inverse_mass;
    Symmetric turning;
    Vec3 linear, surface, acceleration;
    double scale = 1;
    Vec3 offset = {};
    Composite* composite = nullptr;

    Vec3 arm_of(Vec3 arm) const { return scale * arm + offset; }
    Vec3 velocity_at(Vec3 arm) const { return linear + cross(surface, arm); }
    double lightness(Vec3 arm, Vec3 direction) const {
        const Vec3 turned = cross(arm, direction);
        return inverse_mass * (1 + dot(turned, turning * turned));
    }
    void push(Vec3 arm, Vec3 impulse) {
        linear = linear + inverse_mass * impulse;
        surface = surface + inverse_mass * (turning * cross(arm, impulse));
    }
};

PointCollider collider_of(const BodyVelocity& velocity, const Turning& turning, std::uint32_t slot, const BounceRule& rule) {
    const auto d = [](float x) { return static_cast<double>(x); };
    const float(&t)[8] = turning.entries;
    PointCollider body{d(velocity.inverse_mass),
                       {d(t[0]), d(t[1]), d(t[2]), d(t[3]), d(t[4]), d(t[5])},
                       widened(velocity.linear),
                       widened(velocity.surface),
                       {}};
    if (velocity.inverse_mass == 0) return body;
    body.acceleration = widened(rule.gravity);
    for (const Wrench* wrenches : rule.wrenches)
        if (wrenches) body.acceleration = body.acceleration + body.inverse_mass * widened(wrenches[slot].force);
    return body;
}

PointCollider collider_of(Composite& composite, const Place& member, const BounceRule& rule) {
    const CompositeMotion& motion = composite.motion;
    PointCollider whole{.inverse_mass = 0, .turning = {}, .linear = motion.velocity_m_s, .surface = motion.spin_rad_s, .acceleration = {}};
    whole.scale = member.radius, whole.offset = centre_of(member) - motion.centre_m, whole.composite = &composite;
    if (!composite.moves_freely()) return whole;
    whole.inverse_mass = 1 / composite.mass_kg;
    const Symmetric lightness = turned(composite.inverse_inertia, motion.turn);
    const double m = composite.mass_kg;
    whole.turning = {m * lightness.xx, m * lightness.xy, m * lightness.xz, m * lightness.yy, m * lightness.yz, m * lightness.zz};
    whole.acceleration = widened(rule.gravity) + composite.pushed_m_s2;
    return whole;
}

PointCollider collider_in(const ShapeContacts& contacts, const Bodies& bodies, std::uint32_t slot, const BounceRule& rule,
                          Composites* composites) {
    const std::uint32_t mover =
        composites == nullptr || slot >= bodies.count() ? kNoComposite : composites->mover_of(bodies.properties[slot].id);
    if (mover != kNoComposite) return collider_of(composites->all()[mover], bodies.place[slot], rule);
    return collider_of(bodies.velocity[slot], contacts.turning(slot), slot, rule);
}

// The points of a lane, and the two bodies.
struct FaceCollision {
    PointCollider a, b;
    Vec3 normal;
    double restitution, friction;
    const ShapeBatch* batch;
    int lane, points;

    FaceCollision(const ShapeContacts& contacts, const Bodies& bodies, const ShapeBatch& of, int i, int count, const BounceRule& rule,
                  Composites* composites)
        : a(collider_in(contacts, bodies, of.a[i], rule, composites)),
          b(collider_in(contacts, bodies, of.b[i], rule, composites)),
          normal(vector_of_lane(of.nx, of.ny, of.nz, i)),
          restitution(static_cast<double>(of.restitution[i])),
          friction(static_cast<double>(of.friction[i])),
          batch(&of),
          lane(i),
          points(count) {}

    const ShapePoint& point(int p) const { return batch->points[static_cast<std::size_t>(p)]; }
    Vec3 a_arm(int p) const { return a.arm_of(vector_of_lane(point(p).ax, point(p).ay, point(p).az, lane)); }
    Vec3 b_arm(int p) const { return b.arm_of(vector_of_lane(point(p).bx, point(p).by, point(p).bz, lane)); }
    Vec3 apart(int p) const { return b.velocity_at(b_arm(p)) - a.velocity_at(a_arm(p)); }
    double gap(int p) const { return static_cast<double>(point(p).gap[lane]); }
    double lightness(int p, Vec3 direction) const { return a.lightness(a_arm(p), direction) + b.lightness(b_arm(p), direction); }
    bool can_bounce() const { return restitution > 0 && a.inverse_mass + b.inverse_mass > 0; }
    bool bounces(int p, const BounceRule& rule) const {
        const double speed = dot(apart(p), normal);
        return speed < -static_cast<double>(rule.min_speed) &&
               gap(p) < static_cast<double>(rule.margin) - static_cast<double>(rule.step_s) * speed;
    }
    // See speed_after in contact_kernels.cpp.
    double speed_after(int p, const BounceRule& rule) const {
        const double pull = dot(b.acceleration - a.acceleration, normal), half = 0.5 * static_cast<double>(rule.step_s) * pull;
        const double approach = std::max(-(dot(apart(p), normal) + half), 0.0), gained = -2 * pull * std::max(gap(p), 0.0);
        const double impact_squared = std::max(approach * approach + gained, 0.0);
        return std::min(std::sqrt(std::max(restitution * restitution * impact_squared - gained, 0.0)), approach) - half;
    }
    void push(int p, Vec3 impulse) { a.push(a_arm(p), -impulse), b.push(b_arm(p), impulse); }
};

// The points of a lane that collide now: how fast each is to part, and its impulse along the normal.
struct BouncingFace {
    FaceCollision collision;
    ShapeBatch* batch;
    std::array<bool, kMaxManifoldPoints> bouncing = {};
    std::array<double, kMaxManifoldPoints> after = {}, along = {};

    // Whether there are any.
    bool begin(const BounceRule& rule) {
        for (std::size_t p = 0; p < static_cast<std::size_t>(collision.points); ++p)
            if ((bouncing[p] = collision.bounces(static_cast<int>(p), rule))) after[p] = collision.speed_after(static_cast<int>(p), rule);
        return std::ranges::any_of(bouncing, [](bool does) { return does; });
    }
    void push() {
        for (int p = 0; p < collision.points; ++p) {
            const auto n = static_cast<std::size_t>(p);
            if (!bouncing[n]) continue;
            const double missing = after[n] - dot(collision.apart(p), collision.normal);
            const double change = std::max(missing / collision.lightness(p, collision.normal), -along[n]);
            along[n] += change;
            collision.push(p, change * collision.normal);
        }
    }
    // Friction, and what is kept of the impulses.
    void end() {
        for (int p = 0; p < collision.points; ++p) {
            const auto n = static_cast<std::size_t>(p);
            if (!bouncing[n]) continue;
            const Vec3 apart = collision.apart(p), slip = apart - dot(apart, collision.normal) * collision.normal;
            if (const double speed = length(slip); speed > 0) {
                const Vec3 direction = (1 / speed) * slip;
                const double stops = speed / collision.lightness(p, direction);
                collision.push(p, -std::min(stops, collision.friction * along[n]) * direction);
            }
            const int i = collision.lane;
            ShapePoint& point = batch->points[n];
            point.bounced[i] += static_cast<float>(along[n]);
            // The impulse from before no longer presses.
            point.normal_impulse[i] = point.tx[i] = point.ty[i] = point.tz[i] = 0;
        }
    }
};

void set_velocity(BodyVelocity& velocity, const PointCollider& body) {
    if (body.composite != nullptr) {
        if (body.composite->moves_freely())
            body.composite->motion.velocity_m_s = body.linear, body.composite->motion.spin_rad_s = body.surface;
        return;
    }
    set_single(velocity.linear, body.linear), set_single(velocity.surface, body.surface);
}

}  // namespace

void ShapeContacts::begin_bounces() {
    for (ShapeBatch& batch : batches_)
        for (ShapePoint& point : batch.points) point.bounced = physics::lanes(0);
}

bool ShapeContacts::any_bounces(const Bodies& bodies, std::uint32_t block, const BounceRule& rule, const Composites* composites) const {
    const ShapeLane* lane = lanes(block).data();
    for (const ShapeBatch& batch : batches(block))
        for (int i = 0; i < kLanes; ++i, ++lane) {
            if (lane->points == 0 || is_moved(batch, i) != (composites != nullptr)) continue;
            const FaceCollision collision(*this, bodies, batch, i, lane->points, rule, const_cast<Composites*>(composites));
            if (!collision.can_bounce()) continue;
            for (int p = 0; p < collision.points; ++p)
                if (collision.bounces(p, rule)) return true;
        }
    return false;
}

// All that collides of two bodies, each of whose solids may have a face of its own.
void ShapeContacts::bounce(Bodies& bodies, std::uint32_t block, const BounceRule& rule, Composites* composites) {
    ShapeLane* lane = lanes(block).data();
    for (ShapeBatch& batch : batches(block))
        for (int i = 0; i < kLanes; ++i, ++lane) {
            if (lane->points == 0 || lane->of_compound || is_moved(batch, i) != (composites != nullptr)) continue;
            const Part face{&batch, i, lane};
            bounce(bodies, std::span(&face, 1), rule, composites);
        }
    if (!has_parts_) return;
    thread_local std::vector<Part> parts;
    list_parts(block, bodies.count(), parts);
    for (std::size_t begin = 0, end = 0; begin < parts.size(); begin = end) {
        const Part& first = parts[begin];
        while (end < parts.size() && parts[end].is_of(first)) ++end;
        if (first.what->of_compound && is_moved(*first.batch, first.lane) == (composites != nullptr))
            bounce(bodies, std::span(parts).subspan(begin, end - begin), rule, composites);
    }
}

void ShapeContacts::bounce(Bodies& bodies, std::span<const Part> lanes, const BounceRule& rule, Composites* composites) {
    thread_local std::vector<BouncingFace> faces;
    faces.clear();
    for (const Part& part : lanes) {
        if (part.what->points == 0) continue;
        BouncingFace face{FaceCollision(*this, bodies, *part.batch, part.lane, part.what->points, rule, composites), part.batch};
        if (face.collision.can_bounce() && face.begin(rule)) faces.push_back(face);
    }
    if (faces.empty()) return;
    PointCollider a = faces[0].collision.a, b = faces[0].collision.b;
    const auto each_face = [&](const auto& f) {
        for (BouncingFace& face : faces) {
            face.collision.a = a, face.collision.b = b;
            f(face);
            a = face.collision.a, b = face.collision.b;
        }
    };
    for (int round = 0; round < kBounceRounds; ++round) each_face([](BouncingFace& face) { face.push(); });
    each_face([](BouncingFace& face) { face.end(); });
    const ShapeBatch& batch = *faces[0].batch;
    set_velocity(bodies.velocity[batch.a[faces[0].collision.lane]], a);
    if (lanes[0].what->obstacle == kNoSlot) set_velocity(bodies.velocity[batch.b[faces[0].collision.lane]], b);
}

}  // namespace meld::physics
