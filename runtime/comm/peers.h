// Notices a process that keeps the others waiting, and tells the user which one: a stopped process answers nothing and says nothing,
// and the run would seem to hang.
#pragma once

#include <mpi.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace meld::comm {

// The processes of a run that are on this machine see by a table in shared memory how many operations each has begun, at the cost of
// one store an operation; the others are only known to be elsewhere.
class Peers {
  public:
    // Collective.
    explicit Peers(MPI_Comm communicator);
    ~Peers();
    Peers(const Peers&) = delete;
    Peers& operator=(const Peers&) = delete;

    // This process begins an operation of all: it has waited for the last one no longer.
    void begin_operation();
    // To be called now and then while waiting. Once a wait is long, tells on standard error who is late, from one process alone.
    void look();

  private:
    using Clock = std::chrono::steady_clock;
    struct alignas(64) Place {
        std::atomic<std::uint64_t> operations;
    };

    std::size_t count() const { return pids_.size(); }
    // Whether it has not begun the operation in which this process waits.
    bool late(std::size_t process) const;
    bool stopped(std::size_t process) const;
    // Of several that wait, the first on this machine speaks.
    bool speaks() const;

    std::size_t process_ = 0;
    std::vector<int> pids_;  // Of each process; 0: it cannot be seen from here.
    Place* table_ = nullptr;
    std::uint64_t operations_ = 0;
    std::optional<Clock::time_point> waits_since_;
    std::vector<std::size_t> told_;  // Who was said to be late in this wait.
};

}  // namespace meld::comm
