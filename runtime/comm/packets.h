// What every communicator asks of the packets it is given.
#pragma once

#include "runtime/base/assert.h"
#include "runtime/comm/communicator.h"

namespace meld::comm {

// A packet to itself or to a part that does not exist is a bug of the caller, as are two packets to one part.
inline void check_packets(const std::vector<Packet>& packets, int part, int parts) {
    [[maybe_unused]] std::vector<bool> seen;
#ifdef CLAYMELD_ASSERTIONS
    seen.resize(static_cast<std::size_t>(parts));
#endif
    for (const Packet& packet : packets) {
        MELD_CHECK(packet.part >= 0 && packet.part < parts && packet.part != part, "packet of part {} to part {} of {}", part, packet.part,
                   parts);
        MELD_EXPECT(!seen[static_cast<std::size_t>(packet.part)], "two packets of part {} to part {}", part, packet.part);
#ifdef CLAYMELD_ASSERTIONS
        seen[static_cast<std::size_t>(packet.part)] = true;
#endif
    }
}

}  // namespace meld::comm
