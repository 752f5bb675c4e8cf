// Messages over MPI. Private to runtime/comm.
#pragma once

#include <mpi.h>

#include <vector>

#include "runtime/comm/transport/mpi_wait.h"
#include "runtime/comm/transport/transport.h"

namespace meld::comm {

class MpiTransport final : public Transport {
  public:
    // The communicator must be used by nothing else.
    explicit MpiTransport(MPI_Comm communicator);

    int process() const override { return process_; }
    int processes() const override { return processes_; }
    void send(std::span<const std::byte> bytes, int to, int tag, Kind kind) override;
    void receive(std::span<std::byte> bytes, int from, int tag) override;
    bool complete() override;
    std::optional<Packet> take(int tag) override;
    void begin_barrier() override;
    bool barrier_is_over() override;
    void swap_words(std::span<const std::uint64_t> mine, std::span<std::uint64_t> theirs) override;
    void pause() override { backoff_.wait(); }
    void go_on() override { backoff_.reset(); }

  private:
    MPI_Comm communicator_;
    int process_ = 0;
    int processes_ = 1;
    MPI_Request barrier_ = MPI_REQUEST_NULL;
    std::vector<MPI_Request> begun_;
    Backoff backoff_;
};

}  // namespace meld::comm
