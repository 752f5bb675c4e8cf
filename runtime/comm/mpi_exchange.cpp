#include "runtime/comm/mpi_exchange.h"

#include <algorithm>
#include <limits>

#include "runtime/base/assert.h"
#include "runtime/comm/mpi_wait.h"

namespace meld::comm {

namespace {

constexpr std::size_t kNowhere = std::numeric_limits<std::size_t>::max();

// A process may begin round k+1 while another is still in round k, but not round k+2, which requires the other to be in the barrier of k+1.
// So two tags, used in turn, keep the rounds apart.
constexpr int kConsensusTags[2] = {1, 2};
// Here the receiver knows how many messages each process sends, and messages of one pair do not overtake each other.
constexpr int kCountsTag = 3;

}  // namespace

MpiExchange::MpiExchange(MPI_Comm communicator, std::size_t chunk_bytes) : communicator_(communicator), chunk_bytes_(chunk_bytes) {
    MELD_CHECK(chunk_bytes > 0 && chunk_bytes <= static_cast<std::size_t>(std::numeric_limits<int>::max()), "chunk of {} bytes",
               chunk_bytes);
    MPI_Comm_rank(communicator_, &process_);
    MPI_Comm_size(communicator_, &processes_);
    const auto processes = static_cast<std::size_t>(processes_);
    place_of_process_.assign(processes, kNowhere);
    send_counts_.resize(processes);
    receive_counts_.resize(processes);
}

// The NBX algorithm: T. Hoefler, C. Siebert, A. Lumsdaine, "Scalable Communication Protocols for Dynamic Sparse Data
// Exchange", PPoPP 2010, algorithm 2. A synchronous send is complete when its receiver has begun to receive; a process whose
// sends are complete enters the barrier; when the barrier is complete, every message of the round has been received.
std::vector<Packet> MpiExchange::by_consensus(const std::vector<Packet>& packets) {
    MELD_EXPECT(sends_.empty(), "{} packets of an earlier round are under way", sends_.size());
    const int tag = kConsensusTags[round_++ % 2];
    for (const Packet& packet : packets) send_chunks(packet, tag);

    std::vector<Packet> received;
    MPI_Request barrier = MPI_REQUEST_NULL;
    bool in_barrier = false;
    Backoff backoff;
    for (int complete = 0; complete == 0;) {
        if (receive_one(tag, received)) {
            backoff.reset();
            continue;
        }
        if (in_barrier) {
            MPI_Test(&barrier, &complete, MPI_STATUS_IGNORE);
        } else {
            int all_sent = 0;
            MPI_Testall(static_cast<int>(sends_.size()), sends_.data(), &all_sent, MPI_STATUSES_IGNORE);
            if (all_sent != 0) {
                MPI_Ibarrier(communicator_, &barrier);
                in_barrier = true;
                backoff.reset();
            }
        }
        backoff.wait();
    }
    sends_.clear();
    for (const Packet& packet : received) place_of_process_[static_cast<std::size_t>(packet.process)] = kNowhere;
    std::ranges::sort(received, {}, &Packet::process);
    MELD_ENSURE(std::ranges::adjacent_find(received, {}, &Packet::process) == received.end(), "two packets of one process");
    return received;
}

void MpiExchange::send_chunks(const Packet& packet, int tag) {
    std::size_t begin = 0;
    do {
        const std::size_t size = std::min(chunk_bytes_, packet.bytes.size() - begin);
        MPI_Issend(packet.bytes.data() + begin, static_cast<int>(size), MPI_BYTE, packet.process, tag, communicator_,
                   &sends_.emplace_back());
        begin += size;
    } while (begin < packet.bytes.size());
}

// Takes one waiting message of this round and appends it to the packet of its sender; false if none waits.
bool MpiExchange::receive_one(int tag, std::vector<Packet>& received) {
    int found = 0;
    MPI_Message message = MPI_MESSAGE_NULL;
    MPI_Status status;
    MPI_Improbe(MPI_ANY_SOURCE, tag, communicator_, &found, &message, &status);
    if (found == 0) return false;
    int size = 0;
    MPI_Get_count(&status, MPI_BYTE, &size);
    std::vector<std::byte>& bytes = packet_from(status.MPI_SOURCE, received).bytes;
    const std::size_t begin = bytes.size();
    bytes.resize(begin + static_cast<std::size_t>(size));
    MPI_Mrecv(bytes.data() + begin, size, MPI_BYTE, &message, MPI_STATUS_IGNORE);
    return true;
}

Packet& MpiExchange::packet_from(int process, std::vector<Packet>& received) {
    MELD_EXPECT(process >= 0 && process < processes_ && process != process_, "a packet of process {}", process);
    std::size_t& place = place_of_process_[static_cast<std::size_t>(process)];
    if (place == kNowhere) {
        place = received.size();
        received.push_back({process, {}});
    }
    return received[place];
}

std::vector<Packet> MpiExchange::by_counts(const std::vector<Packet>& packets) {
    MELD_EXPECT(sends_.empty() && receives_.empty(), "{} packets of an earlier round are under way", sends_.size() + receives_.size());
    // A word contains size + 1, or 0 if there is no packet: a packet may be empty.
    std::ranges::fill(send_counts_, 0);
    for (const Packet& packet : packets) send_counts_[static_cast<std::size_t>(packet.process)] = packet.bytes.size() + 1;
    MPI_Request counts = MPI_REQUEST_NULL;
    MPI_Ialltoall(send_counts_.data(), 1, MPI_UINT64_T, receive_counts_.data(), 1, MPI_UINT64_T, communicator_, &counts);
    wait_patiently(counts);

    MELD_CHECK(receive_counts_[static_cast<std::size_t>(process_)] == 0, "process {} sends itself a packet", process_);

    std::vector<Packet> received;
    for (int from = 0; from < processes_; ++from) {
        const std::uint64_t count = receive_counts_[static_cast<std::size_t>(from)];
        if (count > 0) received.push_back({from, std::vector<std::byte>(count - 1)});
    }
    for (Packet& packet : received) {
        for (std::size_t begin = 0; begin < packet.bytes.size(); begin += chunk_bytes_) {
            const std::size_t size = std::min(chunk_bytes_, packet.bytes.size() - begin);
            MPI_Irecv(packet.bytes.data() + begin, static_cast<int>(size), MPI_BYTE, packet.process, kCountsTag, communicator_,
                      &receives_.emplace_back());
        }
    }
    for (const Packet& packet : packets) {
        for (std::size_t begin = 0; begin < packet.bytes.size(); begin += chunk_bytes_) {
            const std::size_t size = std::min(chunk_bytes_, packet.bytes.size() - begin);
            MPI_Isend(packet.bytes.data() + begin, static_cast<int>(size), MPI_BYTE, packet.process, kCountsTag, communicator_,
                      &sends_.emplace_back());
        }
    }
    wait_patiently(receives_);
    wait_patiently(sends_);
    receives_.clear();
    sends_.clear();
    return received;
}

}  // namespace meld::comm
