// How a run under mpirun is ended when somebody asks for it, whatever mpirun makes of that.
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

class Ending {
  public:
    // `program` is what mpirun was told to run, as so many processes. The caller is the parent of mpirun and has no other children; it also
    // becomes that of processes whose parent ends, as long as this object lives.
    Ending(pid_t mpirun, const std::string& program, int processes);
    ~Ending();
    Ending(const Ending&) = delete;
    Ending& operator=(const Ending&) = delete;

    // The processes are to end well: each gets this signal as soon as it handles it. Only kEndWellSignal reaches those on other machines.
    void ask(int signal);
    // They have done what they were asked for, and have not ended.
    void forget();
    // They are to end at once.
    void insist();
    // They do nothing any more, and are killed, mpirun too.
    void kill_now();
    // To be called every few milliseconds until mpirun has ended: goes on with what was asked.
    void look();
    // mpirun has ended and has been waited for. Whatever has outlived it, and what it has left behind, goes.
    void clean_up();

    // What mpirun was told to run.
    const ProgramFile& program() const { return program_; }
    bool asked() const { return asked_; }
    // A process has been told, and says what comes of it; otherwise none had come so far.
    bool heard() const { return !told_.empty(); }
    // Not all have ended by themselves.
    bool insisted() const { return insisted_; }
    // mpirun has not.
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
