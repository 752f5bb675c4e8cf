// The neighbours of a catom on a lattice, as an evaluation holds them: an entry for each of kNeighbourRoom ports, -1 where there is none, 0
// for ports that the lattice does not have. A fixed length, so that all are looked at in a few instructions.
#pragma once

#include "runtime/module/abi/geometry_abi.h"

namespace meld {

inline constexpr i32 kNeighbourRoom = 16;
static_assert(kNeighbourRoom >= kMaxPorts);

// One bit for each port at which there is none.
inline u32 missing(const i32* neighbours) {
#ifdef __clang__
    using Numbers = i32 __attribute__((ext_vector_type(kNeighbourRoom)));
    using Bits = bool __attribute__((ext_vector_type(kNeighbourRoom)));
    Numbers all;
    __builtin_memcpy(&all, neighbours, sizeof all);
    return __builtin_bit_cast(u16, __builtin_convertvector(all < 0, Bits));
#else
    u32 bits = 0;
    for (i32 port = 0; port < kNeighbourRoom; ++port) bits |= u32{neighbours[port] < 0} << port;
    return bits;
#endif
}

// How many there are, of a lattice with so many ports.
inline i64 count_neighbours(const i32* neighbours, i32 ports) { return ports - __builtin_popcount(missing(neighbours)); }

}  // namespace meld
