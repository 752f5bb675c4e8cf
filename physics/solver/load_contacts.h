// What contacts do to the members of composites in a step, for their loads: the impulses of each substep, as they have been applied at its
// end, and those of bounces along the normal. Contacts of shapes may bounce or find their points anew within a substep
// (load_shape_contacts.cpp): what they have done before, and what the relaxation changes after it, are added up.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "physics/solver/contacts.h"
#include "physics/solver/shapes/shape_contacts.h"
#include "physics/solver/turning/turning_friction.h"
#include "physics/statics/loads.h"

namespace meld::physics {

class LoadContacts {
  public:
    // After a new list: which lanes a member of a composite has a part in. Cost: one pass over the contacts.
    void find(const Contacts& contacts, const ShapeContacts& shapes, std::size_t blocks, const Bodies& bodies,
              const Composites& composites);
    // Before a step, in which nothing has bounced yet.
    void begin_step();
    // Before bodies bounce within a substep: a contact that bounces forgets what it has done until then.
    void before_bounces(const Contacts& contacts);
    // Within a substep: before the points of shapes are found anew or bounce, and before a relaxation goes over them.
    void before_points(const ShapeContacts& shapes, const Bodies& bodies);
    void before_relaxation(const ShapeContacts& shapes, const Bodies& bodies);
    // At the beginning of a substep, whose contacts will press; and at its end.
    void begin_substep() { pressing_ = true, noted_ = renewed_ = relaxed_ = false, ++substep_; }
    void end_substep(const Contacts& contacts, const ShapeContacts& shapes, const TurningFriction& turning, const Bodies& bodies,
                     const Composites& composites, Loads& loads);
    std::size_t bytes() const { return lanes_.capacity() * sizeof(Lane) + shape_lanes_.capacity() * sizeof(ShapeLoadLane); }

  private:
    // A member's composite, and its place among all members; kNoComposite for other bodies and obstacles.
    struct Side {
        std::uint32_t composite = kNoComposite, member = 0;
    };
    struct Lane {
        std::uint32_t block, batch;
        std::uint8_t lane;
        bool obstacle;
        Side a, b;
        Vec3 before = {};
        float bounced = 0;
    };
    static const Batch& batch_of(const Contacts& contacts, const Lane& lane);
    // What the points of two bodies do to them, about their centres, as impulses.
    struct Both {
        Pull a, b;
    };
    struct ShapeLoadLane {
        std::uint32_t block, batch;
        std::uint8_t lane;
        Side a, b;
        Both kept = {};
        std::array<float, kMaxManifoldPoints> bounced = {};
    };
    static Side side_of(std::uint32_t slot, const Bodies& bodies, const Composites& composites);
    static Both by_points(const ShapeContacts& shapes, const ShapeLoadLane& lane, const Bodies& bodies);
    static Both by_bounces(const ShapeContacts& shapes, ShapeLoadLane& lane, const Bodies& bodies);
    void find_shapes(const ShapeContacts& shapes, std::size_t blocks, const Bodies& bodies, const Composites& composites);
    void end_shapes(const Contacts& contacts, const ShapeContacts& shapes, const TurningFriction& turning, const Bodies& bodies,
                    const Composites& composites, Loads& loads);

    std::vector<Lane> lanes_;
    std::vector<ShapeLoadLane> shape_lanes_;
    // Counts the substeps of a step.
    std::uint32_t substep_ = 0;
    bool pressing_ = false, noted_ = false;
    // The points of shapes are no longer those that were swept, or some have bounced; a relaxation has gone over them.
    bool renewed_ = false, relaxed_ = false;
};

}  // namespace meld::physics
