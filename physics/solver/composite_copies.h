// How subdomains name the copies of composites that their blocks have (composite_rows.h).
#pragma once

#include <array>
#include <cstdint>

#include "physics/bodies/types.h"

namespace meld::physics {

// By the lowest body of its composite, and its block. An entry is one for the contacts of shapes.
struct CopyName {
    BodyId lowest;
    std::uint32_t is_entry;
    std::uint64_t block;
};
// Where it is in this subdomain.
struct PlaceOfCopy {
    std::uint32_t composite, is_entry, at;
};
// Linear and angular velocity, the latter of an entry in its unit.
using CopyVelocity = std::array<float, 6>;

}  // namespace meld::physics
