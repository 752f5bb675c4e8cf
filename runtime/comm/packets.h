// Packets from what was written for each part, and what every communicator asks of the packets it is given.
#pragma once

#include <span>
#include <vector>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/comm/communicator.h"

namespace meld::comm {

// What was written for each part, by its number; the writers start again with nothing.
inline std::vector<Packet> take_packets(std::span<ByteWriter> by_part) {
    std::vector<Packet> packets;
    for (std::size_t part = 0; part < by_part.size(); ++part)
        if (!by_part[part].empty()) packets.push_back({static_cast<int>(part), by_part[part].take()});
    return packets;
}

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
