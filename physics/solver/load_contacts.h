// What contacts do to the members of composites in a step, for their loads: the impulses of each substep, as they have been applied at its
// end, and those of bounces along the normal.
#pragma once

#include <cstdint>
#include <vector>

#include "physics/solver/contacts.h"
#include "physics/statics/loads.h"

namespace meld::physics {

class LoadContacts {
  public:
    // After a new list: which lanes a member of a composite has a part in. Cost: one pass over the contacts.
    void find(const Contacts& contacts, std::size_t blocks, const Bodies& bodies, const Composites& composites);
    // Before a step, in which nothing has bounced yet.
    void begin_step();
    // Before bodies bounce within a substep: a contact that bounces forgets what it has done until then.
    void before_bounces(const Contacts& contacts);
    // At the beginning of a substep, whose contacts will press; and at its end.
    void begin_substep() { pressing_ = true, noted_ = false; }
    void end_substep(const Contacts& contacts, const Bodies& bodies, const Composites& composites, Loads& loads);
    std::size_t bytes() const { return lanes_.capacity() * sizeof(Lane); }

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

    std::vector<Lane> lanes_;
    bool pressing_ = false, noted_ = false;
};

}  // namespace meld::physics
