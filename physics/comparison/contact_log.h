// The contacts of an engine that searches for them in every step, and the events that follow from comparing two steps.
#pragma once

#include <vector>

#include "physics/solver/engine.h"
#include "runtime/base/bytes.h"

namespace meld::physics {

class ContactLog {
  public:
    // Replaces the contacts by those of the step just done, and appends the events to the world's, sorted.
    void update(World& world, std::vector<ContactReport> contacts);
    const std::vector<ContactReport>& contacts() const { return contacts_; }
    // As for an engine.
    void add_normal_forces(const Bodies& bodies, std::span<ExactSum> of_slot) const;
    // What touches, from which the next events follow; without touches of bodies flagged kRemoved, which end without an event.
    void save(const Bodies& bodies, ByteWriter& out) const;
    // Errors: they name what is not there.
    Result<void> load(const World& world, ByteReader& in);
    std::size_t bytes() const { return contacts_.capacity() * sizeof(ContactReport) + touching_.capacity() * sizeof(Touch); }

  private:
    std::vector<ContactReport> contacts_;
    std::vector<Touch> touching_;
};

}  // namespace meld::physics
