// What contacts of bodies with shapes do to the members of composites (load_contacts.h).
#include "physics/solver/load_contacts.h"

namespace meld::physics {

namespace {

void add_pull(Pull& sum, const Pull& more, double factor) { sum = {sum.force + factor * more.force, sum.torque + factor * more.torque}; }
// A contact without an impulse; most of those of a list.
bool presses_nothing(const ShapeBatch& batch, int i) {
    for (const ShapePoint& point : batch.points)
        if (point.normal_impulse[i] != 0) return false;
    return true;
}

}  // namespace

void LoadContacts::find_shapes(const ShapeContacts& shapes, std::size_t blocks, const Bodies& bodies, const Composites& composites) {
    shape_lanes_.clear();
    for (std::uint32_t block = 0; block < blocks; ++block) {
        const std::span<const ShapeBatch> batches = shapes.batches(block);
        for (std::uint32_t n = 0; n < batches.size(); ++n)
            for (int i = 0; i < kLanes; ++i) {
                const Side a = side_of(batches[n].a[i], bodies, composites), b = side_of(batches[n].b[i], bodies, composites);
                if (a.composite == kNoComposite && b.composite == kNoComposite) continue;
                shape_lanes_.push_back({.block = block, .batch = n, .lane = static_cast<std::uint8_t>(i), .a = a, .b = b});
            }
    }
}

LoadContacts::Both LoadContacts::by_points(const ShapeContacts& shapes, const ShapeLoadLane& lane, const Bodies& bodies) {
    const ShapeBatch& batch = shapes.batches(lane.block)[lane.batch];
    const int i = lane.lane;
    Both sum;
    if (presses_nothing(batch, i)) return sum;
    const Vec3 normal = vector_of_lane(batch.nx, batch.ny, batch.nz, i);
    const double a_radius = bodies.place[batch.a[i]].radius, b_radius = bodies.place[batch.b[i]].radius;
    for (const ShapePoint& point : batch.points) {
        const Vec3 impulse = static_cast<double>(point.normal_impulse[i]) * normal + vector_of_lane(point.tx, point.ty, point.tz, i);
        add_pull(sum.a, {impulse, cross(a_radius * vector_of_lane(point.ax, point.ay, point.az, i), impulse)}, -1);
        add_pull(sum.b, {impulse, cross(b_radius * vector_of_lane(point.bx, point.by, point.bz, i), impulse)}, 1);
    }
    return sum;
}

// Those since the last substep.
LoadContacts::Both LoadContacts::by_bounces(const ShapeContacts& shapes, ShapeLoadLane& lane, const Bodies& bodies) {
    const ShapeBatch& batch = shapes.batches(lane.block)[lane.batch];
    const int i = lane.lane;
    const Vec3 normal = vector_of_lane(batch.nx, batch.ny, batch.nz, i);
    const double a_radius = bodies.place[batch.a[i]].radius, b_radius = bodies.place[batch.b[i]].radius;
    Both sum;
    for (std::size_t p = 0; p < batch.points.size(); ++p) {
        const ShapePoint& point = batch.points[p];
        if (point.bounced[i] == lane.bounced[p]) continue;
        const Vec3 impulse = static_cast<double>(point.bounced[i] - lane.bounced[p]) * normal;
        lane.bounced[p] = point.bounced[i];
        add_pull(sum.a, {impulse, cross(a_radius * vector_of_lane(point.ax, point.ay, point.az, i), impulse)}, -1);
        add_pull(sum.b, {impulse, cross(b_radius * vector_of_lane(point.bx, point.by, point.bz, i), impulse)}, 1);
    }
    return sum;
}

void LoadContacts::before_points(const ShapeContacts& shapes, const Bodies& bodies) {
    if (!pressing_ || renewed_) return;
    renewed_ = true;
    for (ShapeLoadLane& lane : shape_lanes_) lane.kept = by_points(shapes, lane, bodies);
}

void LoadContacts::before_relaxation(const ShapeContacts& shapes, const Bodies& bodies) {
    if (!pressing_ || !renewed_ || relaxed_) return;
    relaxed_ = true;
    for (ShapeLoadLane& lane : shape_lanes_) {
        const Both now = by_points(shapes, lane, bodies);
        add_pull(lane.kept.a, now.a, -1), add_pull(lane.kept.b, now.b, -1);
    }
}

void LoadContacts::end_shapes(const Contacts& contacts, const ShapeContacts& shapes, const TurningFriction& turning, const Bodies& bodies,
                              const Composites& composites, Loads& loads) {
    const auto push = [&](const ShapeLoadLane& lane, const Side& side, const Pull& pull) {
        if (side.composite == kNoComposite || composites.all()[side.composite].asleep != 0 || pull.force == Vec3{}) return;
        loads.push(composites, side.composite, side.member, pull.force, pull.torque, {2 * substep_, lane.block});
    };
    for (ShapeLoadLane& lane : shape_lanes_) {
        Both done = by_bounces(shapes, lane, bodies);
        if (renewed_) add_pull(done.a, lane.kept.a, 1), add_pull(done.b, lane.kept.b, 1);
        if (!renewed_ || relaxed_) {
            const Both now = by_points(shapes, lane, bodies);
            add_pull(done.a, now.a, 1), add_pull(done.b, now.b, 1);
        }
        const Vec3 torque = turning.torque_of_shapes(contacts, shapes, lane.block, lane.batch, lane.lane);
        add_pull(done.a, {{}, torque}, -1), add_pull(done.b, {{}, torque}, 1);
        push(lane, lane.a, done.a), push(lane, lane.b, done.b);
    }
}

}  // namespace meld::physics
