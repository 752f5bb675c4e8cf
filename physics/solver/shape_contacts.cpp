// Which bodies with shapes may touch what, and where they do.
#include "physics/solver/shape_contacts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>
#include <unordered_map>

#include "physics/bodies/denormals.h"
#include "physics/solver/contacts.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

constexpr std::size_t kShapeBlocksPerJob = 2, kTurnedPerJob = 4096;
// As for spheres (contacts.cpp).
constexpr std::size_t kShapeSegment = 384;
constexpr int kShapeColours = 64;

Core core_of(const ShapeContacts::Setup& setup, std::uint32_t slot) {
    const BodyShapes::Index index = setup.shapes.of(setup.bodies.properties[slot].id);
    if (index == 0) return {{}, setup.bodies.place[slot].radius};
    const BodyShape& shape = setup.shapes.kind(index).shape;
    return {shape.core_m, shape.rounding_m};
}

double least_of(const ShapeContacts::Setup& setup, std::uint32_t slot) {
    const BodyShapes::Index index = setup.shapes.of(setup.bodies.properties[slot].id);
    return index == 0 ? setup.bodies.place[slot].radius : setup.shapes.kind(index).least_m;
}

void set_lane(Lanes& x, Lanes& y, Lanes& z, int i, Vec3 v) {
    x[i] = static_cast<float>(v.x), y[i] = static_cast<float>(v.y), z[i] = static_cast<float>(v.z);
}

double speed_of(const BodyVelocity& v) { return length(widened(v.surface)); }

}  // namespace

// One worker's workspace: the lanes of its block, near ones first.
struct ShapeContacts::Arena {
    PairSearch search;
    // By how many points they have: several, few, none.
    std::array<std::vector<Chosen>, 3> near;
    std::vector<std::uint64_t> used;
    std::vector<std::uint8_t> colour;
    std::vector<Chosen> lanes;
    // What no two lanes of a batch may share, below `keys`: a body, or a composite that moves freely.
    std::size_t keys = 0;
    std::unordered_map<std::uint32_t, std::uint32_t> key_of_composite;
    std::uint32_t key(const Composites& composites, BodyId body, std::uint32_t otherwise) {
        const std::uint32_t composite = composites.mover_of(body);
        if (composite == kNoComposite) return otherwise;
        const auto [at, made] = key_of_composite.try_emplace(composite, static_cast<std::uint32_t>(keys));
        if (made) ++keys;
        return at->second;
    }

    // Puts some into whole batches so that no two lanes of a batch share a body.
    void colour_lanes(std::span<const Chosen> some, std::size_t bodies, const Chosen& nobody);
};

void ShapeContacts::Arena::colour_lanes(std::span<const Chosen> some, std::size_t bodies, const Chosen& nobody) {
    colour.resize(some.size());
    for (std::size_t begin = 0; begin < some.size(); begin += kShapeSegment) {
        const std::size_t end = std::min(some.size(), begin + kShapeSegment);
        used.assign(bodies, 0);
        std::array<std::size_t, kShapeColours + 1> next{};
        for (std::size_t i = begin; i < end; ++i) {
            std::uint64_t& first = used[some[i].keys.first];
            const std::uint64_t other = some[i].keys.second == kNoSlot ? 0 : used[some[i].keys.second];
            const int free = std::countr_one(first | other);
            colour[i] = static_cast<std::uint8_t>(free);
            ++next[static_cast<std::size_t>(free)];
            if (free == kShapeColours) continue;
            first |= std::uint64_t{1} << free;
            if (some[i].keys.second != kNoSlot) used[some[i].keys.second] |= std::uint64_t{1} << free;
        }
        for (std::size_t c = 0; c < next.size(); ++c) {
            const std::size_t count = next[c], start = lanes.size();
            // Where all colours are taken, each gets a batch of its own.
            lanes.resize(start + (c == kShapeColours ? kLanes * count : (count + kLanes - 1) / kLanes * kLanes), nobody);
            next[c] = start;
        }
        for (std::size_t i = begin; i < end; ++i) {
            lanes[next[colour[i]]] = some[i];
            next[colour[i]] += colour[i] == kShapeColours ? kLanes : 1;
        }
    }
}

std::vector<ShapeContacts::Ended> ShapeContacts::take_out(const Bodies& bodies, const Composites& composites) {
    std::vector<Ended> ended;
    kept_.clear();
    const auto gone = [&](std::uint32_t slot) { return (bodies.properties[slot].flags & kRemoved) != 0; };
    const auto indifferent = [&](std::uint32_t a, std::uint32_t b, bool obstacle) {
        if (composites.empty() && composites.joined().empty()) return false;
        return obstacle ? composites.immovable(bodies.properties[a]) : composites.indifferent(bodies.properties[a], bodies.properties[b]);
    };
    for (std::size_t n = 0; n < batches_.size(); ++n)
        for (int i = 0; i < kLanes; ++i) {
            const ShapeBatch& batch = batches_[n];
            const ShapeLane& lane = lanes_[kLanes * n + static_cast<std::size_t>(i)];
            if (batch.a[i] >= bodies.count() || (lane.points == 0 && lane.touching == 0)) continue;
            const bool obstacle = lane.obstacle != kNoSlot;
            const BodyId a = bodies.properties[batch.a[i]].id, b = obstacle ? lane.obstacle : bodies.properties[batch.b[i]].id;
            if (gone(batch.a[i]) || (!obstacle && gone(batch.b[i])) || indifferent(batch.a[i], batch.b[i], obstacle)) {
                if (lane.touching != 0 && (!lane.is_part() || lane.part == 0)) ended.push_back({a, b, obstacle});
                continue;
            }
            const bool swapped = !obstacle && b < a;
            Kept& kept = kept_.emplace_back();
            kept.key = swapped ? key_of(b, a, false) : key_of(a, obstacle ? code_of(lane) : b, obstacle);
            kept.axis = swapped ? kNoAxis : lane.axis;
            kept.points = lane.points, kept.touching = lane.touching;
            const float sign = swapped ? -1.0f : 1.0f;
            for (std::size_t p = 0; p < lane.points; ++p) {
                const ShapePoint& point = batch.points[p];
                const float on_a[3] = {point.ax[i], point.ay[i], point.az[i]};
                const float on_b[3] = {lane.is_part() ? batch.nx[i] : point.bx[i], lane.is_part() ? batch.ny[i] : point.by[i],
                                       lane.is_part() ? batch.nz[i] : point.bz[i]};
                std::copy_n(swapped ? on_b : on_a, 3, kept.of[p].first);
                std::copy_n(swapped ? on_a : on_b, 3, kept.of[p].second);
                kept.of[p].normal_impulse = point.normal_impulse[i];
                const float tangent[3] = {sign * point.tx[i], sign * point.ty[i], sign * point.tz[i]};
                std::copy_n(tangent, 3, kept.of[p].tangent);
            }
        }
    batches_.clear(), moved_.clear(), lanes_.clear(), first_.clear();
    return ended;
}

// Body a comes first in the result where both are in the block's order; obstacles follow the pairs.
void ShapeContacts::choose(const Setup& setup, const Reach& reach, std::uint32_t block, Arena& arena) const {
    const Bodies& bodies = setup.bodies;
    arena.search.search(setup.grid, bodies, block, reach.search);
    const std::span<const std::uint32_t> slots = arena.search.slots();
    const std::uint32_t nobody = motionless_slot(bodies, block);
    const Chosen none{{nobody, nobody}, {0, kNoSlot}, kNoSlot};
    arena.lanes.clear(), arena.key_of_composite.clear();
    arena.keys = slots.size();
    const bool composed = !setup.composites.empty(), selective = composed || !setup.composites.joined().empty();
    const auto place = [&](const Chosen& chosen, int points) { arena.near[points > 2 ? 0 : points > 0 ? 1 : 2].push_back(chosen); };
    // All parts of a surface are there, whether it has as many directions or not.
    const auto sort_parts = [&](Chosen chosen) {
        std::array<Manifold, kMaxSurfaceContacts> found;
        AxisHint hint = kNoAxis;
        const std::uint32_t slot = chosen.slots.first;
        const int count = setup.obstacles.collide_shape(chosen.obstacle, core_of(setup, slot), poses_[slot], reach.near_m, hint, found);
        for (int part = 0; part < kMaxSurfaceContacts; ++part) {
            chosen.part = static_cast<std::uint8_t>(part);
            place(chosen, part < count ? found[static_cast<std::size_t>(part)].count : 0);
        }
    };
    const auto sort = [&](const Chosen& chosen) {
        if (chosen.obstacle != kNoSlot && setup.obstacles.is_surface(chosen.obstacle)) return sort_parts(chosen);
        ShapeBatch pair;
        pair.a[0] = chosen.slots.first, pair.b[0] = chosen.slots.second;
        ShapeLane lane{.obstacle = chosen.obstacle};
        Manifold found;
        collide_lane(setup, pair, 0, lane, reach.near_m, found);
        place(chosen, found.count);
    };
    const auto lay = [&] {
        for (std::vector<Chosen>& some : arena.near) {
            arena.colour_lanes(some, arena.keys, none);
            some.clear();
        }
    };
    for (const BodyPair pair : arena.search.pairs()) {
        const std::uint32_t a = slots[pair.first], b = slots[pair.second];
        const BodyProperties &first = bodies.properties[a], &second = bodies.properties[b];
        if (((first.flags | second.flags) & kShaped) == 0) continue;
        if (selective && setup.composites.indifferent(first, second)) continue;
        if (!composed)
            sort({{a, b}, pair, kNoSlot});
        else
            sort({{a, b},
                  {arena.key(setup.composites, first.id, pair.first), arena.key(setup.composites, second.id, pair.second)},
                  kNoSlot});
    }
    lay();
    const Block& own = setup.grid.blocks()[block];
    for (std::uint32_t slot = own.first; slot < own.first + own.count; ++slot) {
        const BodyProperties& what = bodies.properties[slot];
        if ((what.flags & kShaped) == 0 || (what.flags & kFixed) != 0 || (composed && setup.composites.immovable(what))) continue;
        const std::uint32_t number = slot - own.first;
        const Place& where = bodies.place[slot];
        const double reach_m = reach.search.apart_m + reach.ahead_s * length(velocity_of(bodies.velocity[slot]));
        for (std::uint32_t obstacle = 0; obstacle < setup.obstacles.count(); ++obstacle)
            if (setup.obstacles.may_reach(obstacle, centre_of(where), where.radius, reach_m))
                sort({{slot, nobody}, {composed ? arena.key(setup.composites, what.id, number) : number, kNoSlot}, obstacle});
    }
    lay();
}

void ShapeContacts::empty_batch(ShapeBatch& batch) {
    batch = ShapeBatch{};
    for (ShapePoint& point : batch.points) point.gap = physics::lanes(kNoContactGap);
}

void ShapeContacts::set_materials(const Setup& setup, ShapeBatch& batch, int i, const ShapeLane& lane) {
    const auto of_body = [&](std::uint32_t slot) { return setup.materials[setup.bodies.properties[slot].material]; };
    const Material own = of_body(batch.a[i]),
                   other = lane.obstacle == kNoSlot ? of_body(batch.b[i]) : setup.materials[setup.obstacles.material(lane.obstacle)];
    batch.friction[i] = common_friction(own, other);
    batch.restitution[i] = std::max(own.restitution, other.restitution);
}

void ShapeContacts::recall(const Bodies& bodies, ShapeBatch& batch, ShapeLane& lane, int i) const {
    const bool obstacle = lane.obstacle != kNoSlot;
    const BodyId a = bodies.properties[batch.a[i]].id, b = obstacle ? lane.obstacle : bodies.properties[batch.b[i]].id;
    const bool swapped = !obstacle && b < a;
    const std::uint64_t key = swapped ? key_of(b, a, false) : key_of(a, obstacle ? code_of(lane) : b, obstacle);
    const auto found = std::ranges::lower_bound(kept_, key, {}, &Kept::key);
    if (found == kept_.end() || found->key != key) return;
    lane.touching = found->touching, lane.points = found->points;
    if (!swapped) lane.axis = found->axis;
    const float sign = swapped ? -1.0f : 1.0f;
    for (std::size_t p = 0; p < found->points; ++p) {
        ShapePoint& point = batch.points[p];
        const Kept::Point& was = found->of[p];
        const float(&on_a)[3] = swapped ? was.second : was.first, (&on_b)[3] = swapped ? was.first : was.second;
        point.ax[i] = on_a[0], point.ay[i] = on_a[1], point.az[i] = on_a[2];
        if (lane.is_part())
            batch.nx[i] = on_b[0], batch.ny[i] = on_b[1], batch.nz[i] = on_b[2];
        else
            point.bx[i] = on_b[0], point.by[i] = on_b[1], point.bz[i] = on_b[2];
        point.normal_impulse[i] = was.normal_impulse;
        point.tx[i] = sign * was.tangent[0], point.ty[i] = sign * was.tangent[1], point.tz[i] = sign * was.tangent[2];
    }
}

void ShapeContacts::lay_out(const Setup& setup, const Reach& reach, const std::vector<bool>* wanted, Workers& workers) {
    const std::size_t blocks = setup.grid.blocks().size();
    const Bodies& bodies = setup.bodies;
    turn_all(setup, workers);
    std::ranges::sort(kept_, {}, &Kept::key);
    std::vector<std::vector<Chosen>> of_block(blocks);
    std::vector<Arena> arenas(static_cast<std::size_t>(workers.threads()));
    workers.run((blocks + kShapeBlocksPerJob - 1) / kShapeBlocksPerJob, [&](int worker, std::size_t job) {
        Arena& arena = arenas[static_cast<std::size_t>(worker)];
        for (std::size_t b = job * kShapeBlocksPerJob; b < std::min(blocks, (job + 1) * kShapeBlocksPerJob); ++b) {
            if (wanted != nullptr && !(*wanted)[b]) continue;
            choose(setup, reach, static_cast<std::uint32_t>(b), arena);
            of_block[b] = arena.lanes;
        }
    });
    first_.assign(blocks + 1, 0);
    for (std::size_t b = 0; b < blocks; ++b) first_[b + 1] = first_[b] + static_cast<std::uint32_t>(of_block[b].size() / kLanes);
    batches_.resize(first_.back());
    lanes_.assign(kLanes * std::size_t{first_.back()}, {});
    std::vector<std::size_t> counts(blocks);
    workers.run((blocks + kShapeBlocksPerJob - 1) / kShapeBlocksPerJob, [&](int, std::size_t job) {
        for (std::size_t b = job * kShapeBlocksPerJob; b < std::min(blocks, (job + 1) * kShapeBlocksPerJob); ++b) {
            const Chosen* chosen = of_block[b].data();
            ShapeLane* lane = lanes(b).data();
            for (ShapeBatch& batch : batches(b)) {
                empty_batch(batch);
                for (int i = 0; i < kLanes; ++i, ++chosen, ++lane) {
                    batch.a[i] = chosen->slots.first, batch.b[i] = chosen->slots.second;
                    if (chosen->slots.first >= bodies.count()) continue;
                    ++counts[b];
                    lane->obstacle = chosen->obstacle, lane->part = chosen->part;
                    set_materials(setup, batch, i, *lane);
                    recall(bodies, batch, *lane, i);
                }
            }
        }
    });
    candidates_ = 0;
    for (const std::size_t count : counts) candidates_ += count;
    has_parts_ = std::ranges::any_of(lanes_, &ShapeLane::is_part);
    kept_.clear();
    kept_.shrink_to_fit();
    prepared_ = false;
}

void ShapeContacts::turn(const Setup& setup, std::uint32_t first, std::uint32_t count) {
    const Bodies& bodies = setup.bodies;
    for (std::uint32_t slot = first; slot < first + count; ++slot) {
        const BodyProperties& what = bodies.properties[slot];
        Turning& turning = turnings_[slot];
        const Quat turn = widened(bodies.orientation[slot]);
        poses_[slot] = pose_of(centre_of(bodies.place[slot]), turn);
        const BodyShapes::Index index = (what.flags & kShaped) == 0 ? BodyShapes::Index{0} : setup.shapes.of(what.id);
        Vec3 t{1, 1, 1};
        if (index == 0)
            t = (1 / static_cast<double>(what.inertia_factor)) * t;
        else
            t = setup.shapes.kind(index).turning;
        const Pose& pose = poses_[slot];
        Symmetric sum;
        const double weights[3] = {t.x, t.y, t.z};
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 axis = pose.axes[k];
            const Vec3 weighted = weights[k] * axis;
            sum += {weighted.x * axis.x, weighted.x * axis.y, weighted.x * axis.z,
                    weighted.y * axis.y, weighted.y * axis.z, weighted.z * axis.z};
        }
        const double entries[] = {sum.xx, sum.xy, sum.xz, sum.yy, sum.yz, sum.zz};
        for (int k = 0; k < 6; ++k) turning.entries[k] = static_cast<float>(entries[k]);
        turning.entries[6] = turning.entries[7] = 0;
    }
}

void ShapeContacts::turn_all(const Setup& setup, Workers& workers) {
    const std::size_t count = setup.bodies.count(), with_motionless = setup.bodies.velocity.size();
    MELD_EXPECT(with_motionless >= count, "{} of {} entries", with_motionless, count);
    turnings_.assign(with_motionless, Turning{});
    poses_.resize(count);
    workers.run((count + kTurnedPerJob - 1) / kTurnedPerJob, [&](int, std::size_t job) {
        const std::size_t begin = job * kTurnedPerJob;
        turn(setup, static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(std::min(count - begin, kTurnedPerJob)));
    });
}

void ShapeContacts::collide_lane(const Setup& setup, const ShapeBatch& batch, int i, ShapeLane& lane, double reach_m,
                                 Manifold& found) const {
    const Core a = core_of(setup, batch.a[i]);
    const Pose& a_pose = poses_[batch.a[i]];
    if (lane.obstacle == kNoSlot) return collide(a, a_pose, core_of(setup, batch.b[i]), poses_[batch.b[i]], reach_m, lane.axis, found);
    const Shape& shape = setup.obstacles.shape(lane.obstacle);
    if (const Plane* plane = std::get_if<Plane>(&shape))
        return collide_with_plane(a, a_pose, plane->normal, plane->offset_m, reach_m, lane.axis, found);
    const Box* box = std::get_if<Box>(&shape);
    MELD_CHECK(box != nullptr, "obstacle {} has no parts here", lane.obstacle);
    collide(a, a_pose, {0.5 * box->size_m, 0}, pose_of(box->centre, box->orientation), reach_m, lane.axis, found);
}

void ShapeContacts::empty_lane(ShapeBatch& batch, int i, int from) const {
    for (int p = from; p < kMaxManifoldPoints; ++p) {
        ShapePoint& point = batch.points[static_cast<std::size_t>(p)];
        point.gap[i] = kNoContactGap;
        point.normal_impulse[i] = point.tx[i] = point.ty[i] = point.tz[i] = 0;
    }
}

// The points that a contact had, and which of them have given their impulses to new ones.
struct ShapeContacts::Former {
    struct Point {
        float at[3], normal[3], normal_impulse, tangent[3];
    };
    std::array<Point, kMaxManifoldPoints * kMaxSurfaceContacts> points;
    int count = 0;
    unsigned used = 0;

    void add(const ShapeBatch& batch, int i, const ShapeLane& lane) {
        for (std::size_t p = 0; p < lane.points; ++p) {
            const ShapePoint& point = batch.points[p];
            points[static_cast<std::size_t>(count++)] = {{point.ax[i], point.ay[i], point.az[i]},
                                                         {batch.nx[i], batch.ny[i], batch.nz[i]},
                                                         point.normal_impulse[i],
                                                         {point.tx[i], point.ty[i], point.tz[i]}};
        }
    }
};

// Each point takes the impulses of the former point that was nearest to it on body a, unless that was elsewhere; of parts, unless that had
// another direction.
void ShapeContacts::take_points(const Setup& setup, ShapeBatch& batch, int i, ShapeLane& lane, const Manifold& found,
                                Former& former) const {
    constexpr float kSamePlace = 0.2f * 0.2f, kSameRim = 2 * 2;
    const double a_share = 1 / setup.bodies.place[batch.a[i]].radius;
    const bool obstacle = lane.obstacle != kNoSlot;
    const double b_share = obstacle ? 0 : 1 / setup.bodies.place[batch.b[i]].radius;
    const Vec3 shift = obstacle ? Vec3{} : poses_[batch.b[i]].centre - poses_[batch.a[i]].centre;
    const int before = lane.points;
    set_lane(batch.nx, batch.ny, batch.nz, i, found.normal);
    for (int p = 0; p < found.count; ++p) {
        ShapePoint& point = batch.points[static_cast<std::size_t>(p)];
        const ManifoldPoint& here = found.points[static_cast<std::size_t>(p)];
        set_lane(point.ax, point.ay, point.az, i, a_share * here.at);
        set_lane(point.bx, point.by, point.bz, i, b_share * (here.at - shift));
        point.gap[i] = static_cast<float>(here.gap_m);
        int best = -1;
        float least = found.on_rim ? kSameRim : kSamePlace;
        for (int q = 0; q < former.count; ++q) {
            const Former::Point& was = former.points[static_cast<std::size_t>(q)];
            const float x = was.at[0] - point.ax[i], y = was.at[1] - point.ay[i], z = was.at[2] - point.az[i];
            float away = x * x + y * y + z * z;
            if (lane.is_part()) {
                const float u = was.normal[0] - batch.nx[i], v = was.normal[1] - batch.ny[i], w = was.normal[2] - batch.nz[i];
                const float turned = u * u + v * v + w * w;
                if (turned >= kSamePlace) continue;
                away += turned;
            }
            if ((former.used >> q & 1u) == 0 && away < least) best = q, least = away;
        }
        point.normal_impulse[i] = point.tx[i] = point.ty[i] = point.tz[i] = 0;
        if (best < 0) continue;
        former.used |= 1u << best;
        const Former::Point& was = former.points[static_cast<std::size_t>(best)];
        point.normal_impulse[i] = was.normal_impulse;
        const float along = was.tangent[0] * batch.nx[i] + was.tangent[1] * batch.ny[i] + was.tangent[2] * batch.nz[i];
        point.tx[i] = was.tangent[0] - along * batch.nx[i];
        point.ty[i] = was.tangent[1] - along * batch.ny[i];
        point.tz[i] = was.tangent[2] - along * batch.nz[i];
    }
    if (before > found.count) empty_lane(batch, i, found.count);
    lane.points = static_cast<std::uint8_t>(found.count);
}

std::optional<ShapeContacts::TooDeep> ShapeContacts::refresh(const Setup& setup, std::uint32_t block, const Contact& contact) {
    const Bodies& bodies = setup.bodies;
    std::optional<TooDeep> worst;
    if (has_parts_) refresh_parts(setup, block, contact, worst);
    ShapeLane* lane = lanes(block).data();
    Manifold found;
    for (ShapeBatch& batch : batches(block)) {
        std::uint8_t most = 0;
        for (int i = 0; i < kLanes; ++i, ++lane) {
            if (batch.a[i] >= bodies.count()) continue;
            if (lane->is_part()) {
                most = std::max(most, lane->points);
                continue;
            }
            collide_lane(setup, batch, i, *lane, reach_of(setup, batch, i, contact), found);
            if (found.count == 0) {
                if (lane->points != 0) empty_lane(batch, i, 0);
                lane->points = 0;
                continue;
            }
            Former former;
            former.add(batch, i, *lane);
            take_points(setup, batch, i, *lane, found, former);
            most = std::max(most, lane->points);
            note_depth(setup, batch, i, *lane, found, contact, worst);
        }
        batch.used = most;
    }
    return worst;
}

double ShapeContacts::reach_of(const Setup& setup, const ShapeBatch& batch, int i, const Contact& contact) const {
    const BodyVelocity &a = setup.bodies.velocity[batch.a[i]], &b = setup.bodies.velocity[batch.b[i]];
    return contact.margin_m + contact.ahead_s * (length(velocity_of(b) - velocity_of(a)) + speed_of(a) + speed_of(b));
}

void ShapeContacts::note_depth(const Setup& setup, const ShapeBatch& batch, int i, const ShapeLane& lane, const Manifold& found,
                               const Contact& contact, std::optional<TooDeep>& worst) {
    const Bodies& bodies = setup.bodies;
    const bool obstacle = lane.obstacle != kNoSlot;
    double deepest = 0;
    for (int p = 0; p < found.count; ++p) deepest = std::max(deepest, -found.points[static_cast<std::size_t>(p)].gap_m);
    const double own = least_of(setup, batch.a[i]), other = obstacle ? own : least_of(setup, batch.b[i]);
    if (deepest <= contact.max_overlap_share * (own + other)) return;
    const BodyId id = bodies.properties[batch.a[i]].id, second = obstacle ? id : bodies.properties[batch.b[i]].id;
    if (!worst || std::min(id, second) < std::min(worst->body, worst->other)) worst = {id, second, lane.obstacle, deepest, own};
}

void ShapeContacts::list_parts(std::size_t block, std::size_t bodies, std::vector<Part>& parts) {
    parts.clear();
    ShapeLane* lane = lanes(block).data();
    for (ShapeBatch& batch : batches(block))
        for (int i = 0; i < kLanes; ++i, ++lane)
            if (batch.a[i] < bodies && lane->is_part()) parts.push_back({&batch, i, lane});
    std::ranges::sort(parts, {}, [](const Part& part) { return std::tuple(part.body(), part.what->obstacle, part.what->part); });
}

void ShapeContacts::refresh_parts(const Setup& setup, std::uint32_t block, const Contact& contact, std::optional<TooDeep>& worst) {
    thread_local std::vector<Part> parts;
    list_parts(block, setup.bodies.count(), parts);
    std::array<Manifold, kMaxSurfaceContacts> found;
    for (std::size_t begin = 0, end = 0; begin < parts.size(); begin = end) {
        const Part& first = parts[begin];
        while (end < parts.size() && parts[end].is_of(first)) ++end;
        const double reach_m = reach_of(setup, *first.batch, first.lane, contact);
        const int count = setup.obstacles.collide_shape(first.what->obstacle, core_of(setup, first.body()), poses_[first.body()], reach_m,
                                                        first.what->axis, found);
        Former former;
        for (std::size_t n = begin; n < end; ++n) former.add(*parts[n].batch, parts[n].lane, *parts[n].what);
        std::array<bool, kMaxSurfaceContacts> taken{};
        for (std::size_t n = begin; n < end; ++n) {
            ShapeBatch& batch = *parts[n].batch;
            const int i = parts[n].lane;
            ShapeLane& lane = *parts[n].what;
            const Vec3 last = vector_of_lane(batch.nx, batch.ny, batch.nz, i);
            std::size_t best = kMaxSurfaceContacts;
            double likeness = -2;
            for (std::size_t m = 0; m < static_cast<std::size_t>(count); ++m)
                if (const double like = dot(last, found[m].normal); !taken[m] && like > likeness) best = m, likeness = like;
            if (best == kMaxSurfaceContacts) {
                if (lane.points != 0) empty_lane(batch, i, 0);
                set_lane(batch.nx, batch.ny, batch.nz, i, {});
                lane.points = 0;
                continue;
            }
            taken[best] = true;
            take_points(setup, batch, i, lane, found[best], former);
            note_depth(setup, batch, i, lane, found[best], contact, worst);
        }
    }
}

void ShapeContacts::prepare(std::span<const std::uint32_t> blocks, const Bodies& bodies, Workers& workers) {
    if (empty() || std::exchange(prepared_, true)) return;
    workers.run((blocks.size() + kShapeBlocksPerJob - 1) / kShapeBlocksPerJob, [&](int, std::size_t job) {
        const FlushDenormals flush;
        for (std::size_t i = job * kShapeBlocksPerJob; i < std::min(blocks.size(), (job + 1) * kShapeBlocksPerJob); ++i)
            prepare_shapes(batches(blocks[i]), moved_.data(), bodies.velocity.data(), turnings_.data());
    });
}

void ShapeContacts::warm_start(std::uint32_t block, BodyVelocity* velocities) const {
    if (!empty()) warm_start_shapes(batches(block), moved_.data(), velocities, turnings_.data());
}

void ShapeContacts::sweep(std::uint32_t block, BodyVelocity* velocities, const SweepRule& rule) {
    if (!empty()) sweep_shapes(batches(block), moved_.data(), velocities, turnings_.data(), rule);
}

void ShapeContacts::forget_impulses() {
    const Lanes nothing = physics::lanes(0);
    for (ShapeBatch& batch : batches_)
        for (ShapePoint& point : batch.points) point.normal_impulse = point.tx = point.ty = point.tz = nothing;
}

MovedLanes& ShapeContacts::add_moved(ShapeBatch& batch) {
    batch.moved = static_cast<std::uint32_t>(moved_.size());
    MovedLanes& moved = moved_.emplace_back();
    std::copy_n(batch.a, kLanes, moved.a), std::copy_n(batch.b, kLanes, moved.b);
    const Lanes nothing = physics::lanes(0);
    moved.a_scale = moved.b_scale = physics::lanes(1);
    moved.ax = moved.ay = moved.az = moved.bx = moved.by = moved.bz = nothing;
    return moved;
}

void ShapeContacts::forget_moved() {
    for (ShapeBatch& batch : batches_) batch.moved = kNoSlot;
    moved_.clear();
}

bool ShapeContacts::is_moved(const ShapeBatch& batch, int i) const {
    if (batch.moved == kNoSlot) return false;
    const MovedLanes& moved = moved_[batch.moved];
    return moved.a[i] != batch.a[i] || moved.b[i] != batch.b[i];
}

std::size_t ShapeContacts::bytes() const {
    return moved_.capacity() * sizeof(MovedLanes) + batches_.capacity() * sizeof(ShapeBatch) + lanes_.capacity() * sizeof(ShapeLane) +
           turnings_.capacity() * sizeof(Turning) + poses_.capacity() * sizeof(Pose) + first_.capacity() * sizeof(std::uint32_t);
}

}  // namespace meld::physics
