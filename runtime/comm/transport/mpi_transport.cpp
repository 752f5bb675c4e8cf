#include "runtime/comm/transport/mpi_transport.h"

namespace meld::comm {

MpiTransport::MpiTransport(MPI_Comm communicator) : communicator_(communicator) {
    MPI_Comm_rank(communicator_, &process_);
    MPI_Comm_size(communicator_, &processes_);
}

void MpiTransport::send(std::span<const std::byte> bytes, int to, int tag, Kind kind) {
    const auto begin = kind == Kind::Synchronous ? MPI_Issend : MPI_Isend;
    begin(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, to, tag, communicator_, &begun_.emplace_back());
}

void MpiTransport::receive(std::span<std::byte> bytes, int from, int tag) {
    MPI_Irecv(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, from, tag, communicator_, &begun_.emplace_back());
}

bool MpiTransport::complete() {
    int all = 0;
    MPI_Testall(static_cast<int>(begun_.size()), begun_.data(), &all, MPI_STATUSES_IGNORE);
    if (all != 0) begun_.clear();
    return all != 0;
}

std::optional<Packet> MpiTransport::take(int tag) {
    int found = 0;
    MPI_Message message = MPI_MESSAGE_NULL;
    MPI_Status status;
    MPI_Improbe(MPI_ANY_SOURCE, tag, communicator_, &found, &message, &status);
    if (found == 0) return std::nullopt;
    int size = 0;
    MPI_Get_count(&status, MPI_BYTE, &size);
    Packet packet{status.MPI_SOURCE, std::vector<std::byte>(static_cast<std::size_t>(size))};
    MPI_Mrecv(packet.bytes.data(), size, MPI_BYTE, &message, MPI_STATUS_IGNORE);
    return packet;
}

void MpiTransport::begin_barrier() { MPI_Ibarrier(communicator_, &barrier_); }

bool MpiTransport::barrier_is_over() {
    int over = 0;
    MPI_Test(&barrier_, &over, MPI_STATUS_IGNORE);
    return over != 0;
}

void MpiTransport::swap_words(std::span<const std::uint64_t> mine, std::span<std::uint64_t> theirs) {
    MPI_Request words = MPI_REQUEST_NULL;
    MPI_Ialltoall(mine.data(), 1, MPI_UINT64_T, theirs.data(), 1, MPI_UINT64_T, communicator_, &words);
    wait_with_backoff(words);
}

}  // namespace meld::comm
