// The sparse exchange of packets, in two ways with the same result. Private to runtime/comm.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/comm/transport/transport.h"

namespace meld::comm {

class SparseExchange {
  public:
    // The transport must be used by nothing else in the meantime. Packets longer than chunk_bytes travel as several messages.
    SparseExchange(Transport& transport, std::size_t chunk_bytes);

    // Cost: one message for each packet and a barrier that runs in the background; only the logarithm in the barrier depends on the number
    // of processes.
    std::vector<Packet> by_consensus(const std::vector<Packet>& packets);

    // Cost: one word from each process to each process, then one message for each packet.
    std::vector<Packet> by_counts(const std::vector<Packet>& packets);

  private:
    void send_chunks(const Packet& packet, int tag, Transport::Kind kind);
    bool receive_one(int tag, std::vector<Packet>& received);

    Transport& transport_;
    std::size_t chunk_bytes_;
    unsigned round_ = 0;
    std::vector<std::size_t> place_of_process_;  // In the packets of this round; kNowhere before its first chunk.
    std::vector<std::uint64_t> send_counts_;
    std::vector<std::uint64_t> receive_counts_;
};

}  // namespace meld::comm
