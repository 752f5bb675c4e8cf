// Communication between processes: one process, threads in place of processes (tests), or MPI. The only use of MPI.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace meld::comm {

// One packed message to or from another process.
struct Packet {
    int process = 0;
    std::vector<std::byte> bytes;
};

class Communicator {
  public:
    virtual ~Communicator() = default;
    virtual int process() const = 0;  // 0 .. processes-1
    virtual int processes() const = 0;

    // Sparse exchange: every process calls it together, each with its packets (at most one per destination, none to itself; the receiver
    // need not expect them). Returns what the others sent here, sorted by sending process. Cost: the number of processes that have
    // something to send to each other, plus one small agreement.
    virtual std::vector<Packet> exchange(std::vector<Packet> packets) = 0;

    // Every process gives the same number of bytes; all get all of them, in the order of processes.
    virtual std::vector<std::byte> allgather(std::span<const std::byte> bytes) = 0;
    // As allgather, with any number of bytes from each process.
    virtual std::vector<std::vector<std::byte>> allgather_any(std::span<const std::byte> bytes) = 0;
    virtual void barrier() = 0;
    // Ends all processes at once with this exit code (only for errors that one process found alone).
    [[noreturn]] virtual void abort(int exit_code) = 0;
};

std::unique_ptr<Communicator> make_single();

// Runs body(communicator) on `processes` threads of this process that exchange through memory: the test double of MPI, with the same
// semantics. Rethrows the first exception. A process that waits for one that has failed or finished, or that calls another operation, gets
// an exception too (runtime/comm/transport/threads.h) and does not hang. abort() throws PartAborted.
void run_threads_as_processes(int processes, const std::function<void(Communicator&)>& body);

// Under mpirun/srun: the process's communicator. Initializes MPI (FUNNELED) on the first call, finalizes it when the last communicator is
// destroyed, and cannot be started again after that. If an exception destroys it, it ends all processes with exit code 70, since the others
// would wait for ever: catch exceptions inside its lifetime and call abort(). Close HDF5 files before the last communicator is destroyed.
std::unique_ptr<Communicator> make_mpi();
// Whether this process was started by an MPI launcher.
bool under_mpi();

}  // namespace meld::comm
