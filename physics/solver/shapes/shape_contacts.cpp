// Which bodies with shapes may touch what, and where they do.
#include "physics/solver/shapes/shape_contacts.h"

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

constexpr std::size_t kShapeBlocksPerJob = 2;
// As for spheres (contacts.cpp).
constexpr std::size_t kShapeSegment = 384;
constexpr int kShapeColours = 64;
// Bodies that have moved by less than this share of the least distance from the middle to the surface of a body, also where they are
// farthest from their middles, keep the points at which they touch.
constexpr double kSameShare = 4e-3;

// Of a body that is no compound.
Core core_of(const ShapeContacts::Setup& setup, std::uint32_t slot) {
    const BodyShapes::Index index = setup.shapes.of(setup.bodies.properties[slot].id);
    if (index == 0) return {{}, setup.bodies.place[slot].radius};
    const BodyShape& shape = setup.shapes.kind(index).shape;
    return {shape.core_m, shape.rounding_m};
}

std::span<const ShapePart> parts_of(const ShapeContacts::Setup& setup, std::uint32_t slot) {
    const BodyShapes::Index index = setup.shapes.of(setup.bodies.properties[slot].id);
    return index == 0 ? std::span<const ShapePart>() : setup.shapes.kind(index).shape.parts;
}

double least_of(const ShapeContacts::Setup& setup, std::uint32_t slot, std::uint8_t solid) {
    const BodyShapes::Index index = setup.shapes.of(setup.bodies.properties[slot].id);
    if (index == 0) return setup.bodies.place[slot].radius;
    const BodyShapes::Kind& kind = setup.shapes.kind(index);
    return kind.shape.is_compound() ? physics::solid_of(kind.shape.parts[solid]).least_m() : kind.least_m;
}

PlacedSolid solid_of(const ShapeContacts::Setup& setup, std::uint32_t slot, const Pose& pose, std::uint8_t solid) {
    const std::span<const ShapePart> parts = parts_of(setup, slot);
    if (parts.empty()) return {core_of(setup, slot), pose};
    const ShapePart& part = parts[solid];
    return {{part.core_m, part.rounding_m}, pose_of_part(part, pose)};
}

// The radius of the sphere around the middle of a solid that holds it.
double around(const Core& core) { return length(core.half_m) + core.radius_m; }

// The points of a solid are seen from the middle of the body.
void shift_points(Manifold& found, Vec3 shift) {
    for (int p = 0; p < found.count; ++p) {
        ManifoldPoint& point = found.points[static_cast<std::size_t>(p)];
        point.at = point.at + shift;
    }
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
        const PlacedSolid solid = solid_of(setup, slot, poses_[slot], chosen.a_solid);
        const int count = setup.obstacles.collide_shape(chosen.obstacle, solid.core, solid.pose, reach.near_m, hint, found);
        for (int part = 0; part < kMaxSurfaceContacts; ++part) {
            chosen.part = static_cast<std::uint8_t>(part);
            place(chosen, part < count ? found[static_cast<std::size_t>(part)].count : 0);
        }
    };
    const auto sort = [&](const Chosen& chosen) {
        if (chosen.obstacle != kNoSlot && setup.obstacles.is_surface(chosen.obstacle)) return sort_parts(chosen);
        ShapeBatch pair;
        pair.a[0] = chosen.slots.first, pair.b[0] = chosen.slots.second;
        ShapeLane lane{
            .obstacle = chosen.obstacle, .of_compound = chosen.of_compound, .a_solid = chosen.a_solid, .b_solid = chosen.b_solid};
        Manifold found;
        collide_lane(setup, pair, 0, lane, reach.near_m, found);
        Chosen known = chosen;
        if (chosen.obstacle == kNoSlot && found.count == 0)
            known.apart_until_m = apart_until(chosen.slots.first, chosen.slots.second, found);
        place(known, found.count);
    };
    // Those of the solids of two bodies that may meet however the bodies turn, and the first ones.
    const auto sort_solids = [&](Chosen chosen, double reach_m) {
        const std::uint32_t a = chosen.slots.first, b = chosen.slots.second;
        const bool obstacle = chosen.obstacle != kNoSlot;
        const std::span<const ShapePart> ones = parts_of(setup, a), others = obstacle ? std::span<const ShapePart>() : parts_of(setup, b);
        const std::size_t solids = obstacle ? setup.obstacles.solids(chosen.obstacle) : others.size();
        if (ones.empty() && (obstacle ? solids <= 1 : others.empty())) return sort(chosen);
        chosen.of_compound = true;
        const Vec3 centre = centre_of(bodies.place[a]);
        const double apart = obstacle ? 0 : length(centre_of(bodies.place[b]) - centre);
        const auto radius = [&](std::span<const ShapePart> parts, std::uint32_t slot, std::size_t solid) {
            return parts.empty() ? bodies.place[slot].radius : physics::reach_m(parts[solid]);
        };
        for (std::size_t i = 0; i < std::max<std::size_t>(ones.size(), 1); ++i)
            for (std::size_t j = 0; j < std::max<std::size_t>(solids, 1); ++j) {
                const double own = radius(ones, a, i);
                const bool may_meet = obstacle ? setup.obstacles.solid_may_reach(chosen.obstacle, j, centre, own, reach_m)
                                               : apart < own + radius(others, b, j) + reach_m;
                if (!may_meet && i + j > 0) continue;
                chosen.a_solid = static_cast<std::uint8_t>(i), chosen.b_solid = static_cast<std::uint8_t>(j);
                sort(chosen);
            }
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
        const double reach_m =
            reach.search.apart_m + reach.ahead_s * length(velocity_of(bodies.velocity[b]) - velocity_of(bodies.velocity[a]));
        if (!composed)
            sort_solids({{a, b}, pair, kNoSlot}, reach_m);
        else
            sort_solids(
                {{a, b}, {arena.key(setup.composites, first.id, pair.first), arena.key(setup.composites, second.id, pair.second)}, kNoSlot},
                reach_m);
    }
    lay();
    const Block& own = setup.grid.blocks()[block];
    for (std::uint32_t slot = own.first; slot < own.first + own.count; ++slot) {
        const BodyProperties& what = bodies.properties[slot];
        if ((what.flags & kShaped) == 0 || (what.flags & kFixed) != 0 || (composed && setup.composites.immovable(what))) continue;
        const std::uint32_t number = slot - own.first;
        const Place& where = bodies.place[slot];
        const double apart_m = reach.search.apart_m + reach.ahead_s * length(velocity_of(bodies.velocity[slot]));
        for (std::uint32_t obstacle = 0; obstacle < setup.obstacles.count(); ++obstacle) {
            const double reach_m = apart_m + setup.obstacles.way_of_list_m(obstacle, centre_of(where));
            if (setup.obstacles.may_reach(obstacle, centre_of(where), where.radius, reach_m))
                sort_solids({{slot, slot_of_obstacle(bodies, setup.obstacles, setup.grid.blocks().size(), block, obstacle)},
                             {composed ? arena.key(setup.composites, what.id, number) : number, kNoSlot},
                             obstacle},
                            reach_m);
        }
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

void ShapeContacts::lay_out(const Setup& setup, const Reach& reach, const std::vector<bool>* wanted, Workers& workers) {
    const std::size_t blocks = setup.grid.blocks().size();
    const Bodies& bodies = setup.bodies;
    turn_all(setup, workers);
    std::ranges::sort(kept_, {}, &Kept::place);
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
                    lane->of_compound = chosen->of_compound, lane->a_solid = chosen->a_solid, lane->b_solid = chosen->b_solid;
                    lane->apart_until_m = chosen->apart_until_m;
                    set_materials(setup, batch, i, *lane);
                    recall(bodies, batch, *lane, i);
                }
            }
        }
    });
    candidates_ = 0;
    for (const std::size_t count : counts) candidates_ += count;
    has_parts_ = std::ranges::any_of(lanes_, &ShapeLane::shares_touch);
    kept_.clear();
    kept_.shrink_to_fit();
    prepared_ = false;
}

void ShapeContacts::collide_lane(const Setup& setup, const ShapeBatch& batch, int i, ShapeLane& lane, double reach_m,
                                 Manifold& found) const {
    if (lane.of_compound) return collide_solids(setup, batch, i, lane, reach_m, found);
    const Core a = core_of(setup, batch.a[i]);
    const Pose& a_pose = poses_[batch.a[i]];
    if (lane.obstacle == kNoSlot) return collide(a, a_pose, core_of(setup, batch.b[i]), poses_[batch.b[i]], reach_m, lane.axis, found);
    setup.obstacles.collide_solid(lane.obstacle, 0, a, a_pose, reach_m, lane.axis, found);
}

void ShapeContacts::collide_solids(const Setup& setup, const ShapeBatch& batch, int i, ShapeLane& lane, double reach_m,
                                   Manifold& found) const {
    found.count = 0, found.on_rim = false, found.apart_m = 0;
    const Pose& body = poses_[batch.a[i]];
    const PlacedSolid a = solid_of(setup, batch.a[i], body, lane.a_solid);
    if (lane.obstacle == kNoSlot) {
        const PlacedSolid b = solid_of(setup, batch.b[i], poses_[batch.b[i]], lane.b_solid);
        const double apart = length(b.pose.centre - a.pose.centre) - around(a.core) - around(b.core);
        if (apart >= reach_m) {
            found.apart_m = apart;
            return;
        }
        collide(a.core, a.pose, b.core, b.pose, reach_m, lane.axis, found);
    } else {
        if (!setup.obstacles.solid_may_reach(lane.obstacle, lane.b_solid, a.pose.centre, around(a.core), reach_m)) return;
        if (!setup.obstacles.is_surface(lane.obstacle))
            setup.obstacles.collide_solid(lane.obstacle, lane.b_solid, a.core, a.pose, reach_m, lane.axis, found);
    }
    shift_points(found, a.pose.centre - body.centre);
}

PlacedSolid ShapeContacts::solid_at(const Setup& setup, std::uint32_t slot, std::uint8_t solid) const {
    return solid_of(setup, slot, poses_[slot], solid);
}

void ShapeContacts::empty_lane(ShapeBatch& batch, int i, int from) const {
    for (int p = from; p < kMaxManifoldPoints; ++p) {
        ShapePoint& point = batch.points[static_cast<std::size_t>(p)];
        point.gap[i] = kNoContactGap;
        point.normal_impulse[i] = point.tx[i] = point.ty[i] = point.tz[i] = 0;
    }
}

// The points that a contact had, with how much they might pull, and which of them have given their impulses to new ones.
struct ShapeContacts::Former {
    struct Point {
        float at[3], normal[3], normal_impulse, tangent[3], held;
    };
    std::array<Point, kMaxManifoldPoints * kMaxSurfaceContacts> points;
    int count = 0;
    unsigned used = 0;

    void add(const ShapeBatch& batch, int i, const ShapeLane& lane, const HeldPoints* held = nullptr) {
        for (std::size_t p = 0; p < lane.points; ++p) {
            const ShapePoint& point = batch.points[p];
            points[static_cast<std::size_t>(count++)] = {{point.ax[i], point.ay[i], point.az[i]},
                                                         {batch.nx[i], batch.ny[i], batch.nz[i]},
                                                         point.normal_impulse[i],
                                                         {point.tx[i], point.ty[i], point.tz[i]},
                                                         held == nullptr ? 0 : held->force[p][i]};
        }
    }
};

// What latches hold at points that are no longer there, these points (bits) take over in equal parts, and how much it might be. A push
// would be back after a sweep, but a pull has a limit, and a body that hangs on most of it would fall a little whenever a point is found
// elsewhere.
void ShapeContacts::hand_on_pulls(const Former& former, unsigned to, ShapeBatch& batch, int i, HeldPoints* held) {
    float pull = 0, most = 0;
    for (int q = 0; q < former.count; ++q) {
        if ((former.used >> q & 1u) != 0) continue;
        pull += std::min(former.points[static_cast<std::size_t>(q)].normal_impulse, 0.0f);
        most += former.points[static_cast<std::size_t>(q)].held;
    }
    if (pull == 0 && most == 0) return;
    const auto parts = static_cast<float>(std::popcount(to));
    for (std::size_t p = 0; p < kMaxManifoldPoints; ++p) {
        if ((to >> p & 1u) == 0) continue;
        batch.points[p].normal_impulse[i] += pull / parts;
        if (held != nullptr) held->force[p][i] += most / parts;
    }
}

// Each point takes the impulses of the former point that was nearest to it on body a, unless that was elsewhere; of parts, unless that had
// another direction.
void ShapeContacts::take_points(const Setup& setup, ShapeBatch& batch, int i, ShapeLane& lane, const Manifold& found, Former& former,
                                HeldPoints* held) const {
    constexpr float kSamePlace = 0.2f * 0.2f, kSameRim = 2 * 2;
    const double a_share = 1 / setup.bodies.place[batch.a[i]].radius;
    const bool obstacle = lane.obstacle != kNoSlot;
    const double b_share = obstacle ? 0 : 1 / setup.bodies.place[batch.b[i]].radius;
    const Vec3 shift = obstacle ? Vec3{} : poses_[batch.b[i]].centre - poses_[batch.a[i]].centre;
    // An obstacle that moves turns about the body's centre. The surface velocity of a belt runs round: its arm is the outward normal.
    const bool moves = obstacle && setup.obstacles.moves(lane.obstacle), belt = obstacle && setup.obstacles.belt(lane.obstacle) != 0;
    const double b_arm = moves ? a_share : b_share;
    const int before = lane.points;
    unsigned fresh = 0;
    set_lane(batch.nx, batch.ny, batch.nz, i, found.normal);
    for (int p = 0; p < found.count; ++p) {
        ShapePoint& point = batch.points[static_cast<std::size_t>(p)];
        const ManifoldPoint& here = found.points[static_cast<std::size_t>(p)];
        set_lane(point.ax, point.ay, point.az, i, a_share * here.at);
        set_lane(point.bx, point.by, point.bz, i, belt && !moves ? -found.normal : b_arm * (here.at - shift));
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
        if (held != nullptr)
            held->force[static_cast<std::size_t>(p)][i] = best < 0 ? 0 : former.points[static_cast<std::size_t>(best)].held;
        if (best < 0) {
            fresh |= 1u << p;
            continue;
        }
        former.used |= 1u << best;
        const Former::Point& was = former.points[static_cast<std::size_t>(best)];
        point.normal_impulse[i] = was.normal_impulse;
        const float along = was.tangent[0] * batch.nx[i] + was.tangent[1] * batch.ny[i] + was.tangent[2] * batch.nz[i];
        point.tx[i] = was.tangent[0] - along * batch.nx[i];
        point.ty[i] = was.tangent[1] - along * batch.ny[i];
        point.tz[i] = was.tangent[2] - along * batch.nz[i];
    }
    hand_on_pulls(former, fresh != 0 ? fresh : (1u << found.count) - 1, batch, i, held);
    if (before > found.count) empty_lane(batch, i, found.count);
    if (held != nullptr)
        for (int p = found.count; p < kMaxManifoldPoints; ++p) held->force[static_cast<std::size_t>(p)][i] = 0;
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
            const auto number = static_cast<std::size_t>(&batch - batches_.data());
            HeldPoints* const held = held_.empty() ? nullptr : &held_[number];
            if (lane->is_part()) {
                most = std::max(most, lane->points);
                continue;
            }
            const double reach_m = reach_of(setup, batch, i, contact);
            if (contact.followed && are_same(setup, batch, i, *lane, reach_m - contact.margin_m)) {
                most = std::max(most, lane->points);
                continue;
            }
            const bool far = lane->points == 0 && lane->obstacle == kNoSlot &&
                             (lane->apart_until_m > moved_m_[batch.a[i]] + moved_m_[batch.b[i]] + reach_m ||
                              spheres_are_apart(bodies, batch.a[i], batch.b[i], reach_m));
            if (!far) collide_lane(setup, batch, i, *lane, reach_m, found);
            if (far || found.count == 0) {
                if (!far && lane->obstacle == kNoSlot) lane->apart_until_m = apart_until(batch.a[i], batch.b[i], found);
                if (lane->points != 0) empty_lane(batch, i, 0);
                lane->points = 0;
                if (held != nullptr)
                    for (Lanes& force : held->force) force[i] = 0;
                continue;
            }
            Former former;
            former.add(batch, i, *lane, held);
            take_points(setup, batch, i, *lane, found, former, held);
            batch.same_m[i] = same_at_most_m(setup, batch, i, *lane);
            if (held != nullptr && !lane->of_compound) share_holds_anew(bodies, number, i, lane->points);
            most = std::max(most, lane->points);
            note_depth(setup, batch, i, *lane, found, contact, worst);
        }
        batch.used = most;
    }
    if (!held_.empty() && has_parts_) share_holds_of_compounds(bodies, block);
    return worst;
}

double ShapeContacts::reach_of(const Setup& setup, const ShapeBatch& batch, int i, const Contact& contact) const {
    const BodyVelocity &a = setup.bodies.velocity[batch.a[i]], &b = setup.bodies.velocity[batch.b[i]];
    const std::vector<Bodies::FeatureState>& features = setup.bodies.features;
    const bool may_hold = contact.latch_range_m > contact.margin_m && batch.b[i] < features.size() && features[batch.a[i]].on != 0 &&
                          features[batch.b[i]].on != 0;
    return (may_hold ? contact.latch_range_m : contact.margin_m) +
           contact.ahead_s * (length(velocity_of(b) - velocity_of(a)) + speed_of(a) + speed_of(b));
}

float ShapeContacts::same_at_most_m(const Setup& setup, const ShapeBatch& batch, int i, const ShapeLane& lane) {
    double least_m = least_of(setup, batch.a[i], lane.a_solid);
    if (lane.obstacle == kNoSlot) least_m = std::min(least_m, least_of(setup, batch.b[i], lane.b_solid));
    return static_cast<float>(kSameShare * least_m);
}

void ShapeContacts::note_depth(const Setup& setup, const ShapeBatch& batch, int i, const ShapeLane& lane, const Manifold& found,
                               const Contact& contact, std::optional<TooDeep>& worst) {
    const Bodies& bodies = setup.bodies;
    const bool obstacle = lane.obstacle != kNoSlot;
    double deepest = 0;
    for (int p = 0; p < found.count; ++p) deepest = std::max(deepest, -found.points[static_cast<std::size_t>(p)].gap_m);
    const double own = least_of(setup, batch.a[i], lane.a_solid), other = obstacle ? own : least_of(setup, batch.b[i], lane.b_solid);
    if (deepest <= contact.max_overlap_share * (own + other)) return;
    const BodyId id = bodies.properties[batch.a[i]].id, second = obstacle ? id : bodies.properties[batch.b[i]].id;
    if (!worst || std::min(id, second) < std::min(worst->body, worst->other)) worst = {id, second, lane.obstacle, deepest, own};
}

void ShapeContacts::list_parts(std::size_t block, std::size_t bodies, std::vector<Part>& parts) {
    parts.clear();
    ShapeLane* lane = lanes(block).data();
    for (ShapeBatch& batch : batches(block))
        for (int i = 0; i < kLanes; ++i, ++lane)
            if (batch.a[i] < bodies && lane->shares_touch()) parts.push_back({&batch, i, lane});
    std::ranges::sort(parts, {}, [](const Part& part) {
        const ShapeLane& what = *part.what;
        return std::tuple(part.body(), what.obstacle, part.batch->b[part.lane], what.a_solid, what.b_solid, what.part);
    });
}

void ShapeContacts::refresh_parts(const Setup& setup, std::uint32_t block, const Contact& contact, std::optional<TooDeep>& worst) {
    thread_local std::vector<Part> parts;
    list_parts(block, setup.bodies.count(), parts);
    std::array<Manifold, kMaxSurfaceContacts> found;
    for (std::size_t begin = 0, end = 0; begin < parts.size(); begin = end) {
        const Part& first = parts[begin];
        if (!first.what->is_part()) {
            ++end;
            continue;
        }
        while (end < parts.size() && parts[end].is_of_solid(first)) ++end;
        const double reach_m = reach_of(setup, *first.batch, first.lane, contact);
        const PlacedSolid solid = solid_of(setup, first.body(), poses_[first.body()], first.what->a_solid);
        const int count = setup.obstacles.collide_shape(first.what->obstacle, solid.core, solid.pose, reach_m, first.what->axis, found);
        if (first.what->of_compound)
            for (int m = 0; m < count; ++m)
                shift_points(found[static_cast<std::size_t>(m)], solid.pose.centre - poses_[first.body()].centre);
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

void ShapeContacts::sweep(std::uint32_t block, BodyVelocity* velocities, const SweepRule& rule, float step_s) {
    if (empty()) return;
    if (held_.empty())
        sweep_shapes(batches(block), moved_.data(), velocities, turnings_.data(), rule);
    else
        sweep_held_shapes(batches(block), held_.data() + first_[block], step_s, moved_.data(), velocities, turnings_.data(), rule);
}

void ShapeContacts::forget_impulses() {
    const Lanes nothing = physics::lanes(0);
    for (ShapeBatch& batch : batches_)
        for (ShapePoint& point : batch.points) point.normal_impulse = point.tx = point.ty = point.tz = nothing;
}

bool ShapeContacts::is_moved(const ShapeBatch& batch, int i) const {
    if (batch.moved == kNoSlot) return false;
    const MovedLanes& moved = moved_[batch.moved];
    return moved.a[i] != batch.a[i] || moved.b[i] != batch.b[i];
}

std::size_t ShapeContacts::bytes() const {
    return moved_.capacity() * sizeof(MovedLanes) + held_.capacity() * sizeof(HeldPoints) + batches_.capacity() * sizeof(ShapeBatch) +
           lanes_.capacity() * sizeof(ShapeLane) + turnings_.capacity() * sizeof(Turning) + poses_.capacity() * sizeof(Pose) +
           moved_m_.capacity() * sizeof(double) + first_.capacity() * sizeof(std::uint32_t);
}

}  // namespace meld::physics
