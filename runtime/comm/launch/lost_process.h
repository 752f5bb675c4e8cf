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
class LostProcess {
  public:
    struct Patience {
        // mpirun hears of the end of a process at once, gives the others a second, and is slow where many processes share a core.
        double gone_s = 5;
        // From the start of a process until it takes its place, its program is read, perhaps over a network.
        double coming_s = 20;
        std::chrono::milliseconds between_looks{250};
    };
    // The places of the processes; `program` is what mpirun runs.
    LostProcess(std::span<const liveness::Place> places, pid_t mpirun, ProgramFile program);
    LostProcess(std::span<const liveness::Place> places, pid_t mpirun, ProgramFile program, Patience patience);

    // Call it often, as long as mpirun runs. It returns what mpirun should have noticed by now and has not: that a process is gone, that
    // one ended before it took its place, or that all have ended.
    enum class Sees { Nothing, Gone, NeverCame, AllEnded };
    Sees look();

  private:
    using Clock = std::chrono::steady_clock;

    Sees state();
    // How many processes of the run are on this machine and have not taken their places.
    std::size_t on_their_way() const;

    std::span<const liveness::Place> places_;
    pid_t mpirun_;
    ProgramFile program_;
    Patience patience_;
    std::size_t most_here_ = 0;  // That were seen at the same time.
    Sees sees_ = Sees::Nothing;
    double seconds_ = 0;  // That it has seen so.
    Clock::time_point last_look_;
};

}  // namespace meld::comm
