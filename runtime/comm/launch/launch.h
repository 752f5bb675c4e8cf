// Starts a command as several processes on this machine, so that a user need not know mpirun.
#pragma once

#include <chrono>
#include <csignal>
#include <string>
#include <vector>

#include "runtime/comm/launch/heartbeat.h"
#include "runtime/comm/launch/relay.h"

namespace meld::comm {

// What the processes receive when the user wants the run to end well: at the next tick boundary, with checkpoint and summary.
// (An interrupt itself would make mpirun end them at once.) Programs that may be started here handle it like SIGINT; it may come twice.
inline constexpr int kEndWellSignal = SIGUSR1;
// What a process that is alone receives when the user insists. It takes the user's own signals, which the terminal gives to it as well, for
// the first request, however often they come.
inline constexpr int kEndNowSignal = SIGUSR2;

// The exit code of what could not be started.
inline constexpr int kCannotStart = 127;

// From the order to end at once until a process is killed.
inline constexpr std::chrono::milliseconds kUntilKilled{1200};

struct LaunchOutcome {
    // Of the first process that failed, 0 when none did; 128 + signal for a process killed by a signal; kCannotStart; 130 when the
    // processes had been asked to end and had, but mpirun had not; 143 when they had to be ended.
    int exit_code = 0;
    // The first signal by which the user asked for the end, or 0. The processes may still have finished, with code 0.
    int interrupted_by = 0;
    // Process 0 has said how the run ended; it may not have come so far.
    bool told = false;
    // The signal that ended mpirun itself, or 0; one that ends a process makes it an exit code. Open MPI 4.1 crashes at its own end now
    // and then, when the processes are through.
    int launcher_signal = 0;
    // Why the processes' standard output could not be passed on, an errno, or 0.
    int output_error = 0;
    // The processes gave no sign of life and were killed.
    bool hung = false;
    // A process was killed or crashed, which mpirun had not noticed; the others were killed. The exit code is as if it was killed.
    bool lost = false;
    // Where they were at the end.
    Heartbeat::Standing standing = {};
};

// Runs `command` (looked up along PATH) as that many processes under mpirun and waits. Standard output and error of the processes come
// through as they are (and when stderr is a terminal, the processes are told so, see runtime/base/terminal/progress.h); standard input goes
// to process 0; of a terminal only if it is `typed`, by lines that are passed on. The first SIGINT, SIGTERM or SIGHUP that is not ignored
// is given to the processes as kEndWellSignal, the second ends them at once. Where input is typed, SIGINT stops what is being done:
// whatever is shown after it answers it, and the next one is the first again; SIGTERM and SIGHUP, which end the session, are given as
// SIGTERM. Processes that do not handle it yet are ended; what does not end is killed within two seconds, but for a process that takes its
// time for its results. If this process dies, so do they; if its standard output takes nothing any more, they end as at a first SIGTERM.
// Call it from a process that has no other threads and children and has not started MPI itself. The processes find the table of the
// heartbeat, if there is one, and are killed when they miss it, or when one of them is gone and mpirun waits for it. What a killed run
// leaves in shared memory and in the folder of its session is removed.
LaunchOutcome launch_mpi(int processes, const std::vector<std::string>& command, Heartbeat* heartbeat = nullptr,
                         Relay::Input typed = Relay::Input::Inherited);

// Runs `command` as one process, with all streams of this one and in its process group, and waits; the rest as above. If this process dies,
// so does that one. It must handle kEndWellSignal and kEndNowSignal; until then they wait, as do SIGINT, SIGTERM and SIGHUP.
LaunchOutcome launch_alone(const std::vector<std::string>& command, Heartbeat& heartbeat);

// Why a run of processes ended with this code, if none of our commands documents it: "a process was killed (signal 9), ...". Empty for all
// other codes.
std::string describe_launch_failure(int exit_code);

}  // namespace meld::comm
