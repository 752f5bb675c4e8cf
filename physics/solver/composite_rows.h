// What contacts of composites need besides their batch: lever arms, effective masses, and copies of the composites.
//
// Blocks of one colour share no body, but a composite may reach over many blocks. So each block that has contacts of a composite sweeps a
// copy with a share of its mass and inertia, and after all colours the copies take the mean of their velocities, in the order of the
// blocks: momentum and angular momentum are kept. A composite with contacts in one block has one copy, and is solved exactly as a body.
// (Tonge, Benevolenski, Voroshilov: "Mass splitting for jitter-free parallel rigid body simulation", ACM Trans. on Graphics 31, 2012.)
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/bodies/buffer.h"
#include "physics/bodies/composites.h"
#include "physics/solver/composite_copies.h"
#include "physics/solver/contacts.h"
#include "physics/solver/shapes/shape_contacts.h"

namespace meld::physics {

// A composite with a share of its mass, a cache line. The inverses are 0 where nothing can move it.
struct alignas(64) CompositeCopy {
    float linear[3];
    float inverse_mass;
    float spin[3];
    float zero;
    // xx, xy, xz, yy, yz, zz as seen from the world, and two entries without meaning.
    float inverse_inertia[8];
};

// Beside a batch: the copies of its bodies a and, in joint batches, b. Arms lead from a composite's centre to the surface of its member.
// `lightness` and `slip_lightness` are the inverses of the effective masses along and across the normal; across, of the direction that is
// moved most easily.
struct alignas(32) CompositeRow {
    std::uint32_t a[kLanes];
    std::uint32_t b[kLanes];
    Lanes ax, ay, az;
    Lanes bx, by, bz;
    Lanes lightness, slip_lightness;
};

enum class RowKind { Joint, Mixed };

// The passes over rows (composite_kernels.cpp). `centres` are those of the copies; `held`: the holding impulse of each lane of a latch per
// second, or null.
void refresh_rows(RowKind kind, std::span<const Batch> batches, CompositeRow* rows, const CompositeCopy* copies, const Place* centres,
                  const Bodies& bodies);
void warm_start_rows(RowKind kind, std::span<const Batch> batches, const CompositeRow* rows, CompositeCopy* copies,
                     BodyVelocity* velocities);
void sweep_rows(RowKind kind, std::span<Batch> batches, const CompositeRow* rows, CompositeCopy* copies, BodyVelocity* velocities,
                const Lanes* held, float step_s, const SweepRule& rule);

// Friction against rolling and spinning (turning/turning_lanes.h); `beside`: one for each batch.
struct TurningLanes;
void resist_turning_of_rows(RowKind kind, std::span<const Batch> batches, const CompositeRow* rows, TurningLanes* beside,
                            CompositeCopy* copies, BodyVelocity* velocities, const Lanes* held, float step_s, const SweepRule& rule);

class CompositeRows {
  public:
    // After new batches. Contacts of shapes have copies of their own, entries behind those of the bodies (rows_of_shapes.cpp).
    void lay_out(Contacts& contacts, ShapeContacts& shapes, std::size_t blocks, Bodies& bodies, const Composites& composites,
                 Workers& workers);
    bool empty() const { return copies_.empty() && entries_.empty(); }

    // In a divided world (composite_copies.h): the copies of our blocks, by composite, first those for spheres, in the order of blocks.
    std::vector<PlaceOfCopy> copies_here() const;
    CopyName name_of(const PlaceOfCopy& copy, std::span<const Block> blocks, const Composites& composites) const;
    // After lay_out: the copies of blocks of other subdomains of composites that are here. They have places here, too, so that each copy
    // has its share of the mass and counts in the mean. Returns these places.
    std::vector<PlaceOfCopy> add_copies(std::span<const CopyName> elsewhere, ShapeContacts& shapes, Bodies& bodies,
                                        const Composites& composites, std::span<const Block> blocks);
    CopyVelocity velocity_of(const PlaceOfCopy& copy, const Bodies& bodies) const;
    void set_velocity(const PlaceOfCopy& copy, const CopyVelocity& velocity, Bodies& bodies);

    // Places have changed, or which composites sleep: arms and masses are computed again before they are next used.
    void places_changed() { fresh_ = false; }
    // A step has failed: the composites have the velocities.
    void forget_velocities() { in_copies_ = false; }
    // The copies take the composites' velocities, unless they have them already.
    void begin(Contacts& contacts, ShapeContacts& shapes, std::span<const std::uint32_t> blocks, Bodies& bodies,
               const Composites& composites, Workers& workers);
    // After a sweep over all colours.
    void average(Bodies& bodies, Workers& workers);
    // The composites take the velocities of their copies.
    void collect(const Bodies& bodies, Composites& composites, Workers& workers);

    void warm_start(Contacts& contacts, std::uint32_t block, BodyVelocity* velocities);
    void sweep(Contacts& contacts, std::uint32_t block, BodyVelocity* velocities, float step_s, const SweepRule& rule);
    // The same before a sweep. `pairs` and `obstacles`: beside the batches of the block.
    void resist_turning(Contacts& contacts, std::uint32_t block, TurningLanes* pairs, TurningLanes* obstacles, BodyVelocity* velocities,
                        float step_s, const SweepRule& rule);
    std::span<const CompositeRow> rows_of(std::size_t block) const {
        return std::span(rows_).subspan(first_row_[block], first_row_[block + 1] - first_row_[block]);
    }
    // kNoComposite for the copy of lanes without a body.
    std::uint32_t composite_of(std::uint32_t copy) const { return composite_of_[copy]; }
    std::size_t bytes() const;

  private:
    // Calls f(kind, batches, their rows, latches of the batches or null) for the three stretches of a block.
    template <class F>
    void each_stretch(Contacts& contacts, std::size_t block, const F& f);
    // Calls f(composite, its copies, its entries).
    template <class F>
    void each_copied(Workers& workers, const F& f) const;

    // A copy for the contacts of shapes in a block.
    struct Entry {
        std::uint32_t composite, at;
        std::uint64_t block;
    };
    void lay_out_entries(ShapeContacts& shapes, std::size_t blocks, Bodies& bodies, const Composites& composites);
    void sort_entries(const Composites& composites);
    // An entry behind all others.
    std::uint32_t add_entry(std::uint32_t composite, ShapeContacts& shapes, Bodies& bodies, const Composites& composites) const;
    void begin_entry(std::uint32_t at, ShapeContacts& shapes, Bodies& bodies, const Composite& composite, double share) const;
    void place_arms(ShapeContacts& shapes, std::span<const std::uint32_t> blocks, const Bodies& bodies, const Composites& composites,
                    Workers& workers) const;
    std::span<const Entry> entries_of(std::size_t composite) const {
        if (entries_.empty()) return {};
        return std::span(entries_).subspan(first_entry_[composite], first_entry_[composite + 1] - first_entry_[composite]);
    }

    Buffer<CompositeRow> rows_;
    Buffer<CompositeCopy> copies_;
    Buffer<Place> centres_;
    std::vector<std::uint32_t> composite_of_;
    // By block, and one more.
    std::vector<std::uint32_t> first_row_;
    // By copy that is one of our blocks: its block.
    std::vector<std::uint32_t> block_of_copy_;
    // By composite, and one more: its copies in the order of blocks.
    std::vector<std::uint32_t> first_copy_, copy_of_;
    // In the order of composites, and of blocks; by composite, and one more, the first of its entries.
    std::vector<Entry> entries_;
    std::vector<std::uint32_t> first_entry_;
    bool fresh_ = false, in_copies_ = false;
};

}  // namespace meld::physics
