// Latches of compounds. The middle of a face may be where several solids meet, so the points of all lanes of two bodies that have about one
// normal share the force of a latch. Friction and pulls then act wherever the bodies touch, as between bodies of one solid.
#include <algorithm>
#include <span>
#include <vector>

#include "physics/solver/shapes/shape_contacts.h"
#include "physics/statics/point_shares.h"

namespace meld::physics {

namespace {

// Lanes whose normals differ by less than 11 degrees, here as a cosine, share a force: more than faces that meet swing in a tick, and
// less than between neighbouring faces of usual solids.
constexpr double kAlike = 0.98;

Vec3 normal_of(const ShapeContacts::Part& part) { return vector_of_lane(part.batch->nx, part.batch->ny, part.batch->nz, part.lane); }

// Of a place from a solid, negative within its rounding.
double distance_m(const PlacedSolid& solid, Vec3 at) {
    const Vec3 away = at - solid.pose.centre;
    const auto& [x, y, z] = solid.pose.axes;
    const BodyShape shape{solid.core.half_m, solid.core.radius_m};
    return length(shape.from_core({dot(away, x), dot(away, y), dot(away, z)})) - shape.rounding_m;
}

}  // namespace

// Of the solids that are where the latches are, those that face each other most along their axis.
const ShapeContacts::Part* ShapeContacts::part_held(const Setup& setup, std::span<const Part> parts, const CompoundHold& hold) const {
    const Part* best = nullptr;
    double faces = 0;
    for (const Part& part : parts) {
        if (part.body() != hold.a || part.what->obstacle != kNoSlot || part.batch->b[part.lane] != hold.b || part.what->points == 0)
            continue;
        const double facing = dot(normal_of(part), hold.place.axis);
        if (!(facing > faces)) continue;
        const double a_m = distance_m(solid_at(setup, hold.a, part.what->a_solid), hold.place.at_m);
        const double b_m = distance_m(solid_at(setup, hold.b, part.what->b_solid), hold.place.at_m);
        if (std::max(a_m, b_m) < hold.place.range_m) best = &part, faces = facing;
    }
    return best;
}

void ShapeContacts::hold_compounds(const Setup& setup, std::uint32_t block, std::span<const CompoundHold> holds) {
    if (holds.empty()) return;
    thread_local std::vector<Part> parts;
    list_parts(block, setup.bodies.count(), parts);
    for (const CompoundHold& hold : holds)
        if (const Part* part = part_held(setup, parts, hold))
            add_hold(setup.bodies, static_cast<std::size_t>(part->batch - batches_.data()), part->lane, hold.place);
    share_holds_of_compounds(setup.bodies, block);
}

void ShapeContacts::share_holds_of_compounds(const Bodies& bodies, std::uint32_t block) {
    thread_local std::vector<Part> parts;
    thread_local std::vector<HeldPoint> points;
    list_parts(block, bodies.count(), parts);
    for (std::size_t begin = 0, end = 0; begin < parts.size(); begin = end) {
        while (end < parts.size() && parts[end].is_of(parts[begin])) ++end;
        const std::span<const Part> lanes = std::span(parts).subspan(begin, end - begin);
        if (lanes.front().what->obstacle != kNoSlot) continue;
        points.clear();
        for (const Part& part : lanes)
            for (std::size_t p = 0; p < part.what->points; ++p) {
                Lanes& force = held_of(part).force[p];
                points.push_back({part.batch, part.lane, p, force[part.lane], 0});
                force[part.lane] = 0;
            }
        for (const Part& part : lanes)
            if (held_of(part).all[part.lane] > 0) share_hold_of(bodies, part, lanes);
        std::size_t next = 0;
        for (const Part& part : lanes)
            for (std::size_t p = 0; p < part.what->points; ++p) points[next++].now = held_of(part).force[p][part.lane];
        move_pulls(points);
    }
}

void ShapeContacts::share_hold_of(const Bodies& bodies, const Part& holder, std::span<const Part> lanes) {
    struct Point {
        const Part* part;
        std::size_t number;
    };
    thread_local std::vector<Point> points;
    thread_local std::vector<Vec3> arms;
    thread_local std::vector<double> shares;
    points.clear(), arms.clear();
    const HeldPoints& held = held_of(holder);
    const float force = held.all[holder.lane];
    const Vec3 normal = normal_of(holder);
    const Vec3 at = (1 / static_cast<double>(force)) * vector_of_lane(held.x, held.y, held.z, holder.lane);
    const double radius = bodies.place[holder.body()].radius;
    for (const Part& part : lanes) {
        if (!(dot(normal_of(part), normal) > kAlike)) continue;
        for (std::size_t p = 0; p < part.what->points; ++p) {
            const ShapePoint& point = part.batch->points[p];
            const Vec3 arm = radius * vector_of_lane(point.ax, point.ay, point.az, part.lane) - at;
            points.push_back({&part, p});
            // Of a force along the normal, only the arm across it counts; one solid may be higher than another.
            arms.push_back(arm - dot(arm, normal) * normal);
        }
    }
    if (points.empty()) return;
    shares.resize(points.size());
    shares_of(arms, shares);
    for (std::size_t i = 0; i < points.size(); ++i)
        held_of(*points[i].part).force[points[i].number][points[i].part->lane] += force * static_cast<float>(shares[i]);
}

}  // namespace meld::physics
