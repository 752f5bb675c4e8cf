// Notices a process that keeps the others waiting and reports which one: a stopped process does not answer and prints nothing, and the run
// would seem to hang.
#pragma once

#include <mpi.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace meld::comm {

// The processes of a run on this machine share a table in memory with the number of operations each has begun, at the cost of one store per
// operation; of the others only their existence elsewhere is known.
class Stragglers {
  public:
    // Collective.
    explicit Stragglers(MPI_Comm communicator);
    ~Stragglers();
    Stragglers(const Stragglers&) = delete;
    Stragglers& operator=(const Stragglers&) = delete;

    // This process begins a collective operation, so it no longer waits for the last one.
    void begin_operation();
    // Call it now and then while waiting. Once a wait is long, one process reports on standard error which processes are late.
    void look();

  private:
    using Clock = std::chrono::steady_clock;
    struct alignas(64) Place {
        std::atomic<std::uint64_t> operations;
    };

    std::size_t count() const { return pids_.size(); }
    // Whether that process has not begun the operation in which this one waits.
    bool late(std::size_t process) const;
    bool stopped(std::size_t process) const;
    // If several wait, the first on this machine reports.
    bool speaks() const;

    std::size_t process_ = 0;
    std::vector<int> pids_;  // By process; 0: not visible from here.
    Place* table_ = nullptr;
    std::uint64_t operations_ = 0;
    std::optional<Clock::time_point> waits_since_;
    std::vector<std::size_t> told_;  // The processes reported as late in this wait.
};

}  // namespace meld::comm
