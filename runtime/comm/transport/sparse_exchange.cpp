#include "runtime/comm/transport/sparse_exchange.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "runtime/base/assert.h"

namespace meld::comm {

namespace {

constexpr std::size_t kNowhere = std::numeric_limits<std::size_t>::max();

// A process may begin round k+1 while another is still in round k, but not round k+2, which requires the other to be in the barrier of k+1.
// So two tags, used in turn, keep the rounds apart.
constexpr int kConsensusTags[2] = {1, 2};
// Here the receiver knows how many messages each process sends, and messages of one pair do not overtake each other.
constexpr int kCountsTag = 3;

}  // namespace

SparseExchange::SparseExchange(Transport& transport, std::size_t chunk_bytes) : transport_(transport), chunk_bytes_(chunk_bytes) {
    MELD_CHECK(chunk_bytes > 0 && chunk_bytes <= static_cast<std::size_t>(std::numeric_limits<int>::max()), "chunk of {} bytes",
               chunk_bytes);
    const auto processes = static_cast<std::size_t>(transport_.processes());
    place_of_process_.assign(processes, kNowhere);
    send_counts_.resize(processes);
    receive_counts_.resize(processes);
}

// The NBX algorithm: T. Hoefler, C. Siebert, A. Lumsdaine, "Scalable Communication Protocols for Dynamic Sparse Data
// Exchange", PPoPP 2010, algorithm 2. A synchronous send is complete when its receiver has begun to receive; a process whose
// sends are complete enters the barrier; when the barrier is complete, every message of the round has been received.
std::vector<Packet> SparseExchange::by_consensus(const std::vector<Packet>& packets) {
    const int tag = kConsensusTags[round_++ % 2];
    for (const Packet& packet : packets) send_chunks(packet, tag, Transport::Kind::Synchronous);

    std::vector<Packet> received;
    bool in_barrier = false;
    while (true) {
        if (receive_one(tag, received)) {
            transport_.go_on();
            continue;
        }
        if (in_barrier) {
            if (transport_.barrier_is_over()) break;
        } else if (transport_.complete()) {
            transport_.begin_barrier();
            in_barrier = true;
            transport_.go_on();
        }
        transport_.pause();
    }
    transport_.go_on();
    for (const Packet& packet : received) place_of_process_[static_cast<std::size_t>(packet.process)] = kNowhere;
    std::ranges::sort(received, {}, &Packet::process);
    MELD_ENSURE(std::ranges::adjacent_find(received, {}, &Packet::process) == received.end(), "two packets of one process");
    return received;
}

void SparseExchange::send_chunks(const Packet& packet, int tag, Transport::Kind kind) {
    std::size_t begin = 0;
    do {
        const std::size_t size = std::min(chunk_bytes_, packet.bytes.size() - begin);
        transport_.send(std::span(packet.bytes).subspan(begin, size), packet.process, tag, kind);
        begin += size;
    } while (begin < packet.bytes.size());
}

// Takes one waiting message of this round and appends it to the packet of its sender; false if none waits.
bool SparseExchange::receive_one(int tag, std::vector<Packet>& received) {
    std::optional<Packet> message = transport_.take(tag);
    if (!message) return false;
    MELD_EXPECT(message->process >= 0 && message->process < transport_.processes() && message->process != transport_.process(),
                "a packet of process {}", message->process);
    std::size_t& place = place_of_process_[static_cast<std::size_t>(message->process)];
    if (place == kNowhere) {
        place = received.size();
        received.push_back(std::move(*message));
    } else {
        std::vector<std::byte>& bytes = received[place].bytes;
        bytes.insert(bytes.end(), message->bytes.begin(), message->bytes.end());
    }
    return true;
}

std::vector<Packet> SparseExchange::by_counts(const std::vector<Packet>& packets) {
    // A word contains size + 1, or 0 if there is no packet: a packet may be empty.
    std::ranges::fill(send_counts_, 0);
    for (const Packet& packet : packets) send_counts_[static_cast<std::size_t>(packet.process)] = packet.bytes.size() + 1;
    transport_.swap_words(send_counts_, receive_counts_);
    const auto process = static_cast<std::size_t>(transport_.process());
    MELD_CHECK(receive_counts_[process] == 0, "process {} sends itself a packet", process);

    std::vector<Packet> received;
    for (std::size_t from = 0; from < receive_counts_.size(); ++from) {
        const std::uint64_t count = receive_counts_[from];
        if (count > 0) received.push_back({static_cast<int>(from), std::vector<std::byte>(count - 1)});
    }
    for (Packet& packet : received) {
        for (std::size_t begin = 0; begin < packet.bytes.size(); begin += chunk_bytes_) {
            const std::size_t size = std::min(chunk_bytes_, packet.bytes.size() - begin);
            transport_.receive(std::span(packet.bytes).subspan(begin, size), packet.process, kCountsTag);
        }
    }
    for (const Packet& packet : packets)
        if (!packet.bytes.empty()) send_chunks(packet, kCountsTag, Transport::Kind::Standard);
    while (!transport_.complete()) transport_.pause();
    transport_.go_on();
    return received;
}

}  // namespace meld::comm
