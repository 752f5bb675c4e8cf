// Bodies with shapes in the block engine: how they turn, and what their contacts report.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "physics/solver/block_engine.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

// Lanes whose surfaces are nearer than this share of the skin when a list is made may well touch before the next one.
constexpr double kNearShare = 0.5;

// Whether a point of a lane is near, and whether all are far.
struct Nearby {
    bool near = false, far = true;
};
Nearby nearby(const ShapeBatch& batch, int i, const ShapeLane& lane, float near_m, float far_m) {
    Nearby found;
    for (std::size_t p = 0; p < lane.points; ++p) {
        const ShapePoint& point = batch.points[p];
        found.near = found.near || point.gap[i] < near_m || point.normal_impulse[i] > 0 || point.bounced[i] > 0;
        found.far = found.far && point.gap[i] >= far_m;
    }
    return found;
}

// Multiplies the components of v along the axes of a body turned by q.
Vec3 scaled_in_frame(Quat q, Vec3 factors, Vec3 v) {
    const Vec3 own = rotate(conjugate(q), v);
    return rotate(q, {factors.x * own.x, factors.y * own.y, factors.z * own.z});
}

}  // namespace

ShapeContacts::Setup BlockEngine::shape_setup() const {
    return {grid_, world_.bodies, world_.shapes, world_.obstacles, world_.materials, world_.composites};
}

void BlockEngine::lay_out_shapes(const PairSearch::Reach& reach, double ahead_s, const std::vector<bool>* wanted, Workers& workers) {
    if (world_.shapes.empty()) return;
    shape_contacts_.lay_out(shape_setup(), {reach, ahead_s, margin_m_ + kNearShare * skin_m_}, wanted, workers);
}

// The pass over bodies has added forces; a torque turns a body by its tensor.
void BlockEngine::turn_shapes_by_torques(std::uint32_t block, const Wrench* first, const Wrench* second, double step_s) {
    if (first == nullptr && second == nullptr) return;
    Bodies& bodies = world_.bodies;
    for (std::uint32_t slot = grid_.blocks()[block].first; slot < grid_.blocks()[block].first + grid_.blocks()[block].count; ++slot) {
        if ((bodies.properties[slot].flags & kShaped) == 0 || bodies.velocity[slot].inverse_mass == 0) continue;
        const BodyShapes::Kind& kind = world_.shapes.kind(world_.shapes.of(bodies.properties[slot].id));
        Vec3 torque;
        for (const Wrench* wrenches : {first, second})
            if (wrenches != nullptr) torque = torque + widened(wrenches[slot].torque);
        if (torque == Vec3{}) continue;
        BodyVelocity& velocity = bodies.velocity[slot];
        const double share = step_s * static_cast<double>(velocity.inverse_mass) / kind.radius_m;
        set_single(velocity.surface, widened(velocity.surface) +
                                         share * scaled_in_frame(kind.principal(widened(bodies.orientation[slot])), kind.turning, torque));
    }
}

// The free motion of a body keeps its angular momentum: it turns by the spin of the middle of the step, and ends with the spin that the
// momentum implies in its new attitude. Bodies that turn alike about all axes keep their spin.
Moved BlockEngine::move_shaped(std::uint32_t index, float step_s) {
    const Block& block = grid_.blocks()[index];
    Bodies& bodies = world_.bodies;
    struct Turned {
        std::uint32_t slot;
        const BodyShapes::Kind* kind;
        Vec3 momentum;
    };
    thread_local std::vector<Turned> turned;
    turned.clear();
    for (std::uint32_t slot = block.first; slot < block.first + block.count; ++slot) {
        const BodyProperties& what = bodies.properties[slot];
        if ((what.flags & (kShaped | kFixed | kMember)) != kShaped) continue;
        const BodyShapes::Kind& kind = world_.shapes.kind(world_.shapes.of(what.id));
        if (kind.turns_alike) continue;
        const Vec3 t = kind.turning, heavy{1 / t.x, 1 / t.y, 1 / t.z}, surface = widened(bodies.velocity[slot].surface);
        if (surface == Vec3{}) continue;
        const Quat turn = widened(bodies.orientation[slot]);
        turned.push_back({slot, &kind, scaled_in_frame(kind.principal(turn), heavy, surface)});
        const Quat middle = turned_by(turn, (0.5 * static_cast<double>(step_s) / kind.radius_m) * surface);
        set_single(bodies.velocity[slot].surface, scaled_in_frame(kind.principal(middle), t, turned.back().momentum));
    }
    const Moved moved = move_bodies(bodies, block.first, block.count, step_s);
    for (const Turned& one : turned)
        set_single(bodies.velocity[one.slot].surface,
                   scaled_in_frame(one.kind->principal(widened(bodies.orientation[one.slot])), one.kind->turning, one.momentum));
    // Members of composites are not in their places yet.
    if (world_.composites.all().empty()) shape_contacts_.turn(shape_setup(), block.first, block.count);
    return moved;
}

std::optional<std::pair<BodyId, Error>> BlockEngine::refresh_shapes(std::uint32_t block, double dt_s, bool followed) {
    const auto deep = shape_contacts_.refresh(shape_setup(), block,
                                              {.margin_m = kLookAheadShare * 2 * smallest_radius_m_,
                                               .ahead_s = kStepsAhead * dt_s,
                                               .latch_range_m = world_.latch_range_m(),
                                               .max_overlap_share = world_.settings.max_overlap_share,
                                               .followed = followed});
    if (!deep) return std::nullopt;
    if (deep->obstacle == kNoSlot)
        return std::pair(std::min(deep->body, deep->other), world_.overlapping(deep->body, deep->other, deep->overlap_m));
    const auto fine = world_.check_depth(deep->body, deep->least_m, deep->obstacle, deep->overlap_m);
    if (fine) return std::nullopt;
    return std::pair(deep->body, fine.error());
}

template <class F>
void BlockEngine::each_shape_lane(std::size_t block, const F& f) const {
    const std::span<const ShapeBatch> batches = shape_contacts_.batches(block);
    const std::span<const ShapeLane> lanes = shape_contacts_.lanes(block);
    for (std::size_t n = 0; n < lanes.size(); ++n)
        if (batches[n / kLanes].a[n % kLanes] < world_.bodies.count()) f(batches[n / kLanes], static_cast<int>(n % kLanes), lanes[n]);
}

Touch BlockEngine::touch_of_lane(const ShapeBatch& batch, int i, const ShapeLane& lane) const {
    const BodyId a = world_.bodies.properties[batch.a[i]].id;
    if (lane.obstacle != kNoSlot) return {a, lane.obstacle, true};
    return touch_of(a, world_.bodies.properties[batch.b[i]].id);
}

// As find_events does it for spheres: of several points the nearest one counts.
void BlockEngine::find_shape_events(std::uint32_t block, float near_m, float far_m, Chunks<TouchEvent>& events) {
    const std::span<ShapeLane> lanes = shape_contacts_.lanes(block);
    const std::span<const ShapeBatch> batches = std::as_const(shape_contacts_).batches(block);
    for (std::size_t n = 0; n < lanes.size(); ++n) {
        const ShapeBatch& batch = batches[n / kLanes];
        const int i = static_cast<int>(n % kLanes);
        ShapeLane& lane = lanes[n];
        if ((lane.points == 0 && lane.touching == 0) || lane.shares_touch()) continue;
        const Nearby points = nearby(batch, i, lane, near_m, far_m);
        const bool now = points.near || (!points.far && lane.touching != 0);
        if (now == (lane.touching != 0)) continue;
        lane.touching = now ? 1 : 0;
        events.push_back({touch_of_lane(batch, i, lane), now});
    }
    if (!shape_contacts_.has_parts()) return;
    // All parts of a surface, and all solids of two bodies, are one touch.
    thread_local std::vector<ShapeContacts::Part> parts;
    shape_contacts_.list_parts(block, world_.bodies.count(), parts);
    for (std::size_t begin = 0, end = 0; begin < parts.size(); begin = end) {
        Nearby points;
        bool before = false;
        for (; end < parts.size() && parts[end].is_of(parts[begin]); ++end) {
            const Nearby some = nearby(*parts[end].batch, parts[end].lane, *parts[end].what, near_m, far_m);
            points = {points.near || some.near, points.far && some.far};
            before = before || parts[end].what->touching != 0;
        }
        const ShapeLane& first = *parts[begin].what;
        const bool now = points.near || (!points.far && before);
        for (std::size_t n = begin; n < end; ++n) parts[n].what->touching = now ? 1 : 0;
        if (now == before) continue;
        events.push_back({touch_of_lane(*parts[begin].batch, parts[begin].lane, first), now});
    }
}

void BlockEngine::each_shape_touch(std::size_t block,
                                   const std::function<void(const ShapeBatch&, int, const ShapeLane&, double)>& visit) const {
    const double per_substep = last_substep_s_ > 0 ? 1 / last_substep_s_ : 0, per_step = last_dt_s_ > 0 ? 1 / last_dt_s_ : 0;
    each_shape_lane(block, [&](const ShapeBatch& batch, int i, const ShapeLane& lane) {
        if (lane.touching == 0 || (lane.shares_touch() && lane.points == 0)) return;
        double force_n = 0;
        for (std::size_t p = 0; p < lane.points; ++p)
            force_n += per_substep * static_cast<double>(batch.points[p].normal_impulse[i]) +
                       per_step * static_cast<double>(batch.points[p].bounced[i]);
        visit(batch, i, lane, force_n);
    });
}

// One report for all points: their forces together, and the least gap.
void BlockEngine::report_shape_contacts(std::size_t block, const ContactVisitor& visit) const {
    const double per_second = last_substep_s_ > 0 ? 1 / last_substep_s_ : 0;
    each_shape_touch(block, [&](const ShapeBatch& batch, int i, const ShapeLane& lane, double force_n) {
        Vec3 friction;
        double gap = std::numeric_limits<double>::infinity();
        for (std::size_t p = 0; p < lane.points; ++p) {
            const ShapePoint& point = batch.points[p];
            friction = friction + vector_of_lane(point.tx, point.ty, point.tz, i);
            gap = std::min(gap, static_cast<double>(point.gap[i]));
        }
        if (lane.points == 0) gap = world_.settings.separation_share * 2 * smallest_radius_m_;
        const Touch touch = touch_of_lane(batch, i, lane);
        const bool swapped = lane.obstacle == kNoSlot && world_.bodies.properties[batch.a[i]].id != touch.body;
        const double sign = swapped ? -1 : 1;
        const Vec3 normal = vector_of_lane(batch.nx, batch.ny, batch.nz, i);
        visit({touch, sign * normal, gap, force_n, (sign * per_second) * friction});
    });
}

}  // namespace meld::physics
