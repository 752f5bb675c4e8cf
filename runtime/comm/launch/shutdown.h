// Ends a run under mpirun on request, even if mpirun hangs or loses the signal.
//
// Open MPI 4.1 loses a signal that it is to hand on before it has started the processes, and waits for itself for ever if one of them
// ends while it greets them. So the processes are told without it; and whoever is not at an orderly end after a while is killed.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <set>
#include <string>
#include <vector>

#include "runtime/comm/launch/child_processes.h"

namespace meld::comm {

class Shutdown {
  public:
    // `program` is what mpirun was told to run, as so many processes. The caller is the parent of mpirun and has no other children; it also
    // becomes that of processes whose parent ends, as long as this object lives.
    Shutdown(pid_t mpirun, const std::string& program, int processes);
    ~Shutdown();
    Shutdown(const Shutdown&) = delete;
    Shutdown& operator=(const Shutdown&) = delete;

    // Asks the processes to end in an orderly way: each gets this signal as soon as it has a handler for it. Only kEndWellSignal reaches
    // those on other machines.
    void ask(int signal);
    // The processes have done what the signal asked for and go on: forgets that they were asked.
    void forget();
    // Asks the processes to end at once.
    void insist();
    // Kills the processes and mpirun.
    void kill_now();
    // Call it every few milliseconds until mpirun has ended: it carries on what was asked.
    void look();
    // Call it once mpirun has ended and has been waited for: kills what has outlived it, and removes the files that it has left.
    void clean_up();

    // What mpirun was told to run.
    const ProgramFile& program() const { return program_; }
    bool asked() const { return asked_; }
    // Whether a process has received the signal, and so prints what follows from it.
    bool heard() const { return !told_.empty(); }
    // Whether some have not ended by themselves.
    bool insisted() const { return insisted_; }
    // Whether they had to be killed.
    bool killed() const { return killed_; }

  private:
    using Clock = std::chrono::steady_clock;

    // The processes of the run that are there.
    std::vector<pid_t> processes() const;
    void tell(const std::vector<pid_t>& processes);
    void kill_all();
    void remove_session() const;

    pid_t mpirun_;
    ProgramFile program_;
    std::size_t processes_of_run_;
    int signal_ = 0;  // That they were asked by.
    bool asked_ = false, insisted_ = false, killed_ = false;
    Clock::time_point asked_at_, insisted_at_, next_look_;
    Clock::time_point all_there_at_;  // When the last look had found all that were told.
    std::set<pid_t> told_;
};

}  // namespace meld::comm
