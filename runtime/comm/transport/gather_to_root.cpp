#include "runtime/comm/transport/gather_to_root.h"

#include <utility>

namespace meld::comm {

std::vector<std::vector<std::byte>> gather_to_root(Communicator& comm, std::vector<std::byte> mine) {
    const bool first = comm.process() == 0;
    std::vector<std::vector<std::byte>> all(first ? static_cast<std::size_t>(comm.processes()) : 0);
    std::vector<Packet> packets;
    if (first)
        all[0] = std::move(mine);
    else
        packets.push_back({0, std::move(mine)});
    for (Packet& packet : comm.exchange(std::move(packets))) all[static_cast<std::size_t>(packet.process)] = std::move(packet.bytes);
    return all;
}

}  // namespace meld::comm
