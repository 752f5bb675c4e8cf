// Notices that a process of a run has been killed or has crashed and that mpirun waits for it all the same: one that is lost while Open MPI
// 4.1 starts makes mpirun wait for itself for ever, with the other processes or after it has ended them.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <span>

#include "runtime/base/process/liveness.h"
#include "runtime/comm/launch/child_processes.h"

namespace meld::comm {

// Of processes on other machines, which have no place in the table, nothing is assumed.
class Losses {
  public:
    struct Patience {
        // mpirun hears of the end of a process at once, gives the others a second, and is slow where many processes share a core.
        double gone_s = 5;
        // From the start of a process until it takes its place, its program is read, perhaps over a network.
        double coming_s = 20;
        std::chrono::milliseconds between_looks{250};
    };
    // The places of the processes; `program` is what mpirun runs.
    Losses(std::span<const pulse::Place> places, pid_t mpirun, ProgramFile program);
    Losses(std::span<const pulse::Place> places, pid_t mpirun, ProgramFile program, Patience patience);

    // To be called often, as long as mpirun goes on. What it has had the time to notice itself: a process is gone; one is that has not even
    // taken its place; or all have come to their ends.
    enum class Sees { Nothing, Gone, NeverCame, AllEnded };
    Sees look();

  private:
    using Clock = std::chrono::steady_clock;

    Sees state();
    // How many processes of the run are on this machine and have not taken their places.
    std::size_t on_their_way() const;

    std::span<const pulse::Place> places_;
    pid_t mpirun_;
    ProgramFile program_;
    Patience patience_;
    std::size_t most_here_ = 0;  // That were seen at the same time.
    Sees sees_ = Sees::Nothing;
    double seconds_ = 0;  // That it has seen so.
    Clock::time_point last_look_;
};

}  // namespace meld::comm
