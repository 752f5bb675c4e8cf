// Contacts of bodies with shapes, with each other, with spheres and with obstacles: up to four points for each two bodies.
//
// A body of bounding radius R keeps its spin as surface velocity R w, as spheres do. A point at arm r from its centre then moves with
// v + u x (r/R), and an impulse P there changes v by P/m and u by T (r/R x P)/m, where T is R^2 times the inverse of its inertia per kg. So
// arms are stored as shares of R, and a sphere is the special case in which T is a number.
//
// A member of a composite that moves freely is moved through a copy of its composite (composite_rows.h), an entry behind those of the
// bodies, and its arms count from the composite's centre. Only batches with such members have MovedLanes beside them.
//
// A body and a surface of triangles have four lanes, which are its parts: a manifold each, of those that its directions make. They share
// the body, so they lie in different batches. Compounds have a lane for each two of their solids that may meet in any attitude of the
// bodies, and one for the first ones, which speaks for all.
//
// As with spheres, batches of eight lanes are laid out with the candidate list, and impulses stay in place. A lane is two bodies. Lanes
// that are near each other when the list is made come first, so that most of the other batches have no points and cost nothing. Points are
// found anew at the end of each step; within it they follow the bodies' velocities. Two bodies that were found to be apart are compared
// again when they have moved far enough to touch, which changes nothing but the time that it takes. Points that were found go on to follow
// the velocities, also over the ends of steps, until their bodies have moved a little (kSameShare): they are then right to the second order
// of that.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "physics/bodies/bodies.h"
#include "physics/bodies/body_shape.h"
#include "physics/bodies/buffer.h"
#include "physics/bodies/composites.h"
#include "physics/bodies/lanes.h"
#include "physics/bodies/material.h"
#include "physics/bodies/stage.h"
#include "physics/collision/block_grid.h"
#include "physics/collision/core_contacts.h"
#include "physics/collision/obstacles.h"
#include "physics/collision/pair_search.h"
#include "physics/solver/latches/held_place.h"
#include "runtime/base/bytes.h"
#include "runtime/base/error.h"

namespace meld::physics {

// One of the points of eight lanes. Arms are shares of the bodies' bounding radii; impulses act on b, and reversed on a. `lightness` and
// `slip_lightness` are the inverses of the effective masses along and across the normal; `bounced` is the impulse of bounces in this tick.
struct alignas(32) ShapePoint {
    Lanes ax, ay, az;
    Lanes bx, by, bz;
    Lanes gap;
    Lanes normal_impulse;
    Lanes tx, ty, tz;
    Lanes lightness, slip_lightness;
    Lanes bounced;
};

// Eight times two bodies, or a body and an obstacle, whose slot b is the block's motionless entry; so is a where a lane is empty.
struct alignas(32) ShapeBatch {
    std::uint32_t a[kLanes], b[kLanes];
    Lanes nx, ny, nz;
    Lanes friction, restitution;
    std::array<ShapePoint, kMaxManifoldPoints> points;
    // By how much the bodies of a lane may move on before its points are found anew.
    Lanes same_m;
    // The greatest number of points in a lane.
    std::uint32_t used;
    // Its MovedLanes; kNoSlot if no member of a composite is in it.
    std::uint32_t moved = kNoSlot;
};

// What is moved in a batch with members of composites: the entries of copies, otherwise the bodies'. The solver's arm is a point's arm
// times the scale, and the offset.
struct alignas(32) MovedLanes {
    std::uint32_t a[kLanes], b[kLanes];
    Lanes a_scale, ax, ay, az;
    Lanes b_scale, bx, by, bz;
};

// With how much force each of the points of eight lanes may pull, N, where latches hold; and the latches of a lane together, their force
// and its moments, N m: force times place, from the centre of body a along the axes of the world.
struct alignas(32) HeldPoints {
    std::array<Lanes, kMaxManifoldPoints> force;
    Lanes all, x, y, z;
};

// Of a lane that is no part of a contact with a surface.
inline constexpr std::uint8_t kNoPart = 0xff;

struct ShapeLane {
    // Of an obstacle its number; kNoSlot: b is a body.
    std::uint32_t obstacle = kNoSlot;
    AxisHint axis = kNoAxis;
    std::uint8_t points = 0;
    // The same in all parts.
    std::uint8_t touching = 0;
    std::uint8_t part = kNoPart;
    // Whether a or b, which may be an obstacle, is a compound, and which of their solids these are.
    bool of_compound = false;
    std::uint8_t a_solid = 0, b_solid = 0;
    // Two bodies without points have none as long as the sum of what they have moved by (ShapeContacts::moved_m_) and the reach is less.
    float apart_until_m = 0;

    bool is_part() const { return part != kNoPart; }
    // Whether other lanes belong to the same touch, and whether this is the first of them.
    bool shares_touch() const { return is_part() || of_compound; }
    bool is_first() const { return (!is_part() || part == 0) && a_solid == 0 && b_solid == 0; }
};

// How easily a body is turned, T as seen from the world: xx, xy, xz, yy, yz, zz and two entries without meaning.
struct alignas(32) Turning {
    float entries[8];
};

// The passes over batches (shape_kernels.cpp).
// The gaps after a time in which bodies have moved at these velocities, and what is left of `same_m`.
void follow_shapes(std::span<ShapeBatch> batches, const BodyVelocity* velocities, float step_s);
void prepare_shapes(std::span<ShapeBatch> batches, const MovedLanes* moved, const BodyVelocity* velocities, const Turning* turnings);
void warm_start_shapes(std::span<const ShapeBatch> batches, const MovedLanes* moved, BodyVelocity* velocities, const Turning* turnings);
void sweep_shapes(std::span<ShapeBatch> batches, const MovedLanes* moved, BodyVelocity* velocities, const Turning* turnings,
                  const SweepRule& rule);
// The same with latches: an impulse along the normal may go down to minus the force that holds there times `step_s`, and friction counts it
// from there. `held`: one for each batch.
void sweep_held_shapes(std::span<ShapeBatch> batches, const HeldPoints* held, float step_s, const MovedLanes* moved,
                       BodyVelocity* velocities, const Turning* turnings, const SweepRule& rule);

// Friction against rolling and spinning (turning/turning_lanes.h). `beside`, and `held` unless it is null: one for each batch.
struct TurningLanes;
void resist_turning_of_shapes(std::span<const ShapeBatch> batches, TurningLanes* beside, const HeldPoints* held, float step_s,
                              const MovedLanes* moved, BodyVelocity* velocities, const Turning* turnings, const SweepRule& rule);

class ShapeContacts {
  public:
    // What it needs of the scene.
    struct Setup {
        const BlockGrid& grid;
        const Bodies& bodies;
        const BodyShapes& shapes;
        const Obstacles& obstacles;
        std::span<const Material> materials;
        const Composites& composites;
    };
    // Surfaces nearer than this have contacts, farther for bodies that approach fast; and lanes whose surfaces are nearer than `near_m`
    // when the list is made come first.
    struct Reach {
        PairSearch::Reach search;
        double ahead_s = 0, near_m = 0;
    };
    struct Ended {
        BodyId body;
        std::uint32_t other;
        bool is_obstacle;
    };
    // Keeps the impulses and drops the batches; `lay_out` puts them into the new ones. Returns the touches that end here: those of bodies
    // flagged kRemoved, and of bodies between which nothing can happen any more.
    std::vector<Ended> take_out(const Bodies& bodies, const Composites& composites);
    // Of the blocks for which `wanted` is true (null: all).
    void lay_out(const Setup& setup, const Reach& reach, const std::vector<bool>* wanted, Workers& workers);
    // Between take_out and lay_out: what is kept of contacts of these bodies, which other subdomains need (saved_shape_contacts.cpp).
    void pack_kept(const std::vector<bool>& ids_wanted, ByteWriter& out) const;
    void unpack_kept(ByteReader& in);
    bool empty() const { return batches_.empty(); }
    std::size_t candidate_count() const { return candidates_; }

    // Bodies have turned: of these slots, or of all.
    void turn_all(const Setup& setup, Workers& workers);
    void turn(const Setup& setup, std::uint32_t first, std::uint32_t count);
    // What has changed in a time in which bodies have moved at these velocities, to first order, without looking for points.
    void follow(std::uint32_t block, const BodyVelocity* velocities, float step_s) { follow_shapes(batches(block), velocities, step_s); }
    struct Contact {
        double margin_m = 0, ahead_s = 0;
        // Latches hold points of two bodies with features that are on up to this gap.
        double latch_range_m = 0;
        double max_overlap_share = 1;
        // Whether points have followed the velocities to where bodies are now.
        bool followed = false;
    };
    struct TooDeep {
        BodyId body, other;
        std::uint32_t obstacle;
        double overlap_m, least_m;
    };
    // Normals and points of a block from the present places; points keep the impulses of those that were nearest to them. Returns how deep
    // the worst overlap is that is deeper than the settings allow, if any.
    std::optional<TooDeep> refresh(const Setup& setup, std::uint32_t block, const Contact& contact);
    // Places have changed, or which bodies can be moved: effective masses are computed again before they are next used.
    void places_changed() { prepared_ = false; }
    void prepare(std::span<const std::uint32_t> blocks, const Bodies& bodies, Workers& workers);

    void warm_start(std::uint32_t block, BodyVelocity* velocities) const;
    // Latches hold for `step_s`, the duration of a substep.
    void sweep(std::uint32_t block, BodyVelocity* velocities, const SweepRule& rule, float step_s);
    // Friction against rolling and spinning, before a sweep. `beside`: one for each batch of the block.
    void resist_turning(std::uint32_t block, TurningLanes* beside, BodyVelocity* velocities, float step_s, const SweepRule& rule) const;
    // At the start of a step (block_actuation.cpp): makes room for latches; lets all points of a block go; and has the points of one of its
    // lanes (eight a batch) hold with a force between them, at a place in the world. The points share it so that its lever arms are those
    // of the place, or of the nearest place between the points, also when they have been found anew. Nothing if there are none.
    void need_holds();
    void let_go(std::uint32_t block);
    void hold(const Bodies& bodies, std::uint32_t block, std::size_t lane, const HeldPlace& place);
    // The same for bodies in slots a and b of which one at least is a compound (latches/compound_latches.cpp): points of all their solids
    // that have about one normal share the force. Call it once for a block. Nothing where no solids touch at the place.
    struct CompoundHold {
        std::uint32_t a, b;
        HeldPlace place;
    };
    void hold_compounds(const Setup& setup, std::uint32_t block, std::span<const CompoundHold> holds);
    // Restitution (shape_bounces.cpp): all points of two bodies at once, so that a face that lands flat leaves flat.
    // Without composites: the contacts of bodies that move alone. With them: those of the members of composites that move freely, each
    // with the whole composite.
    void begin_bounces();
    bool any_bounces(const Bodies& bodies, std::uint32_t block, const BounceRule& rule, const Composites* composites = nullptr) const;
    void bounce(Bodies& bodies, std::uint32_t block, const BounceRule& rule, Composites* composites = nullptr);
    // The same of the lanes of one touch.
    struct Part;
    void bounce(Bodies& bodies, std::span<const Part> lanes, const BounceRule& rule, Composites* composites);
    void forget_impulses();

    std::span<ShapeBatch> batches(std::size_t block) {
        return block + 1 < first_.size() ? std::span(batches_).subspan(first_[block], first_[block + 1] - first_[block])
                                         : std::span<ShapeBatch>();
    }
    std::span<const ShapeBatch> batches(std::size_t block) const { return const_cast<ShapeContacts*>(this)->batches(block); }
    // How many there are, and the number of a block's first one.
    std::size_t batch_count() const { return batches_.size(); }
    std::size_t first_batch(std::size_t block) const { return block + 1 < first_.size() ? first_[block] : 0; }
    // Eight a batch.
    std::span<ShapeLane> lanes(std::size_t block) {
        return block + 1 < first_.size() ? std::span(lanes_).subspan(kLanes * first_[block], kLanes * (first_[block + 1] - first_[block]))
                                         : std::span<ShapeLane>();
    }
    // The lanes of a block that share their touch with others, those of one touch behind each other.
    struct Part {
        ShapeBatch* batch;
        int lane;
        ShapeLane* what;

        std::uint32_t body() const { return batch->a[lane]; }
        bool is_of(const Part& other) const {
            return body() == other.body() && what->obstacle == other.what->obstacle && batch->b[lane] == other.batch->b[other.lane];
        }
        // Whether both are of one solid and a surface of triangles.
        bool is_of_solid(const Part& other) const { return is_of(other) && what->a_solid == other.what->a_solid; }
    };
    bool has_parts() const { return has_parts_; }
    void list_parts(std::size_t block, std::size_t bodies, std::vector<Part>& parts);
    std::span<const ShapeLane> lanes(std::size_t block) const { return const_cast<ShapeContacts*>(this)->lanes(block); }
    const Turning& turning(std::uint32_t slot) const { return turnings_[slot]; }

    // For CompositeRows, which lays out copies of composites and keeps their velocities and masses.
    std::span<MovedLanes> moved_lanes() { return moved_; }
    // The entries that the solver moves in a lane of a batch with MovedLanes.
    BodyPair moved_in(const ShapeBatch& batch, int i) const { return {moved_[batch.moved].a[i], moved_[batch.moved].b[i]}; }
    MovedLanes& add_moved(ShapeBatch& batch);
    void forget_moved();
    // Makes room for the copies' entries, up to this many in all.
    void add_turnings(std::size_t entries) { turnings_.resize(entries, Turning{}); }
    void set_turning(std::uint32_t entry, const Turning& turning) { turnings_[entry] = turning; }

    // In a snapshot (saved_shape_contacts.cpp), as Contacts does it.
    void save(const BlockGrid& grid, const Bodies& bodies, std::uint32_t block, ByteWriter& out) const;
    // False if they name what is not there.
    bool load(const Setup& setup, std::span<const std::span<const std::byte>> of_block);
    std::size_t bytes() const;

  private:
    // What is kept while batches are laid out again: by the body with the lower number, then the other, or an obstacle.
    struct Kept {
        std::uint64_t key;
        // The solids of compounds, of the first and of the second.
        std::uint16_t solids;
        AxisHint axis;
        std::uint8_t points, touching;
        // Of each point its arms on the first and the second of them, and the impulses on the second. Of a part, whose second has no arms,
        // the normal instead.
        struct Point {
            float first[3], second[3], normal_impulse, tangent[3];
        };
        std::array<Point, kMaxManifoldPoints> of;

        std::pair<std::uint64_t, std::uint16_t> place() const { return {key, solids}; }
    };
    static std::uint16_t solids_of(const ShapeLane& lane, bool swapped) {
        const int first = swapped ? lane.b_solid : lane.a_solid, second = swapped ? lane.a_solid : lane.b_solid;
        return static_cast<std::uint16_t>(first << 8 | second);
    }
    struct Chosen {
        BodyPair slots;
        BodyPair keys;
        std::uint32_t obstacle;
        std::uint8_t part = kNoPart;
        bool of_compound = false;
        std::uint8_t a_solid = 0, b_solid = 0;
        float apart_until_m = 0;
    };
    struct Arena;
    static std::uint64_t key_of(BodyId body, std::uint32_t partner, bool obstacle) {
        return std::uint64_t{body} << 32 | std::uint64_t{partner} << 1 | std::uint64_t{obstacle};
    }
    // Of an obstacle, or a part of it.
    static std::uint32_t code_of(const ShapeLane& lane) {
        return (kMaxSurfaceContacts + 1) * lane.obstacle + (lane.is_part() ? lane.part + 1u : 0u);
    }
    void choose(const Setup& setup, const Reach& reach, std::uint32_t block, Arena& arena) const;
    static void empty_batch(ShapeBatch& batch);
    static void set_materials(const Setup& setup, ShapeBatch& batch, int i, const ShapeLane& lane);
    void recall(const Bodies& bodies, ShapeBatch& batch, ShapeLane& lane, int i) const;
    void collide_lane(const Setup& setup, const ShapeBatch& batch, int i, ShapeLane& lane, double reach_m, Manifold& found) const;
    void collide_solids(const Setup& setup, const ShapeBatch& batch, int i, ShapeLane& lane, double reach_m, Manifold& found) const;
    // Of all parts of a contact, each takes the manifold whose normal is most like its last one.
    void refresh_parts(const Setup& setup, std::uint32_t block, const Contact& contact, std::optional<TooDeep>& worst);
    double reach_of(const Setup& setup, const ShapeBatch& batch, int i, const Contact& contact) const;
    // Whether the points of a lane still serve, also while its bodies go on by `ahead_m`.
    bool are_same(const Setup& setup, const ShapeBatch& batch, int i, const ShapeLane& lane, double ahead_m) const;
    static float same_at_most_m(const Setup& setup, const ShapeBatch& batch, int i, const ShapeLane& lane);
    // For ShapeLane::apart_until_m.
    float apart_until(std::uint32_t a, std::uint32_t b, const Manifold& found) const;
    static bool spheres_are_apart(const Bodies& bodies, std::uint32_t a, std::uint32_t b, double reach_m);
    void note_motion(const Setup& setup, std::uint32_t slot, const Pose& before);
    void turn_body(const Setup& setup, std::uint32_t slot);
    static void note_depth(const Setup& setup, const ShapeBatch& batch, int i, const ShapeLane& lane, const Manifold& found,
                           const Contact& contact, std::optional<TooDeep>& worst);
    void empty_lane(ShapeBatch& batch, int i, int from) const;
    // Whether a contact is one of a composite that moves freely.
    bool is_moved(const ShapeBatch& batch, int i) const;
    struct Former;
    // Of a lane of a batch.
    void add_hold(const Bodies& bodies, std::size_t batch, int i, const HeldPlace& place);
    void share_holds(const Bodies& bodies, std::size_t batch, int i, std::size_t points);
    // The same once points have been found anew: pulls follow the shares.
    void share_holds_anew(const Bodies& bodies, std::size_t batch, int i, std::size_t points);
    // Of compounds: in which lane a latch's force is kept, if in any; sharing those of a block, and that of one lane, `holder`, among the
    // lanes of its two bodies.
    const Part* part_held(const Setup& setup, std::span<const Part> parts, const CompoundHold& hold) const;
    void share_holds_of_compounds(const Bodies& bodies, std::uint32_t block);
    void share_hold_of(const Bodies& bodies, const Part& holder, std::span<const Part> lanes);
    HeldPoints& held_of(const Part& part) { return held_[static_cast<std::size_t>(part.batch - batches_.data())]; }
    PlacedSolid solid_at(const Setup& setup, std::uint32_t slot, std::uint8_t solid) const;
    // `held`: with how much force points may pull, which goes on with their impulses; null: they have no latches.
    static void hand_on_pulls(const Former& former, unsigned to, ShapeBatch& batch, int i, HeldPoints* held);
    void take_points(const Setup& setup, ShapeBatch& batch, int i, ShapeLane& lane, const Manifold& found, Former& former,
                     HeldPoints* held = nullptr) const;
    // Of points that latches hold, with how much force each might pull and now may.
    struct HeldPoint {
        ShapeBatch* batch;
        int lane;
        std::size_t number;
        float before, now;
    };
    // A pull goes where its limit goes: what a point may hold no more, those take over that may hold more than before.
    static void move_pulls(std::span<const HeldPoint> points);

    Buffer<ShapeBatch> batches_;
    Buffer<MovedLanes> moved_;
    // One a batch; empty unless some body has latches.
    Buffer<HeldPoints> held_;
    std::vector<ShapeLane> lanes_;
    // By block, and one more.
    std::vector<std::uint32_t> first_;
    std::vector<Kept> kept_;
    // By slot, also of motionless entries.
    Buffer<Turning> turnings_;
    Buffer<Pose> poses_;
    // By slot: the sum since the list was made of how far points within farthest_m_ of a body went with it.
    std::vector<double> moved_m_;
    double farthest_m_ = 0;
    std::size_t candidates_ = 0;
    bool prepared_ = false, has_parts_ = false;
};

}  // namespace meld::physics
