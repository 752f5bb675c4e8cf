// Makes packets from the bytes written for each process, and checks the packets given to a communicator.
#pragma once

#include <span>
#include <vector>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/comm/transport/communicator.h"

namespace meld::comm {

// The bytes written for each process, by its number; the writers start again empty.
inline std::vector<Packet> take_packets(std::span<ByteWriter> by_process) {
    std::vector<Packet> packets;
    for (std::size_t process = 0; process < by_process.size(); ++process)
        if (!by_process[process].empty()) packets.push_back({static_cast<int>(process), by_process[process].take()});
    return packets;
}

// A packet to itself or to a process that does not exist is a bug of the caller, as are two packets to one process.
inline void check_packets(const std::vector<Packet>& packets, int process, int processes) {
    [[maybe_unused]] std::vector<bool> seen;
#ifdef CLAYMELD_ASSERTIONS
    seen.resize(static_cast<std::size_t>(processes));
#endif
    for (const Packet& packet : packets) {
        MELD_CHECK(packet.process >= 0 && packet.process < processes && packet.process != process,
                   "packet of process {} to process {} of {}", process, packet.process, processes);
        MELD_EXPECT(!seen[static_cast<std::size_t>(packet.process)], "two packets of process {} to process {}", process, packet.process);
#ifdef CLAYMELD_ASSERTIONS
        seen[static_cast<std::size_t>(packet.process)] = true;
#endif
    }
}

}  // namespace meld::comm
