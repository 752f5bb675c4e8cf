#include "runtime/comm/launch/launch.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fmt/format.h>
#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <map>
#include <optional>
#include <span>
#include <string_view>

#include "runtime/base/assert.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/base/terminal/progress.h"
#include "runtime/comm/launch/lost_process.h"
#include "runtime/comm/launch/relay.h"
#include "runtime/comm/launch/shared_folder.h"
#include "runtime/comm/launch/shutdown.h"

extern char** environ;

namespace meld::comm {

namespace {

// The longest time that a signal or the end of the processes may wait.
constexpr int kLookMilliseconds = 20;
constexpr int kLooksUntilToldToEnd = 25;

// Whether a limit on the size of files (ulimit -f) leaves no room for those that Open MPI and PMIx keep in shared memory: a process has
// one of 4 MiB, and the table that they share grows with them. Where it cannot be made, they fail or wait for ever.
bool files_are_short() {
    constexpr rlim_t kFiles_bytes = rlim_t{64} << 20;
    rlimit limit{};
    return getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY && limit.rlim_cur < kFiles_bytes;
}

// Settings for mpirun, each only if the user has not set it.
std::map<std::string, std::string> settings_for(int processes, const Heartbeat* heartbeat) {
    std::map<std::string, std::string> settings = {
        {"OMPI_ALLOW_RUN_AS_ROOT", "1"},
        {"OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"},
        {"OMPI_MCA_rmaps_base_oversubscribe", "1"},
        // Copying through shared memory is faster in virtual machines (60 against 88 microseconds for a megabyte), and the
        // direct copy between processes is forbidden in many containers.
        {"OMPI_MCA_btl_vader_single_copy_mechanism", "none"},
    };
    if (files_are_short()) {
        // Open MPI does without files in memory then, and a run comes so far that it can say which of its own files is too long.
        settings["PMIX_MCA_gds"] = "hash";
        settings["OMPI_MCA_btl"] = "self,tcp";
    }
    if (heartbeat != nullptr) settings[liveness::kVariable] = heartbeat->place();
    // Only then: a process that has a core of its own, and yields it at each poll, waits for the time slices of all other programs. Beside
    // three of them a run of two processes took more than 300 seconds instead of 1.6.
    if (processes > sysconf(_SC_NPROCESSORS_ONLN)) settings["OMPI_MCA_mpi_yield_when_idle"] = "1";
    if (stderr_is_terminal()) {
        settings[kTerminalVariable] = "1";
        settings["COLUMNS"] = std::to_string(terminal_columns());
    }
    return settings;
}

// Variables by which an enclosing launcher gives a process its own rank; the new processes must not inherit them.
bool tells_place_in_another_run(std::string_view variable) {
    return std::ranges::any_of(std::initializer_list<std::string_view>{"OMPI_COMM_WORLD_", "PMIX_", "PMI_", "OMPI_UNIVERSE_SIZE"},
                               [&](std::string_view prefix) { return variable.starts_with(prefix); });
}

std::vector<std::string> environment_for(int processes, const Heartbeat* heartbeat, const SharedFolder& shared) {
    std::map<std::string, std::string> settings = settings_for(processes, heartbeat);
    if (!shared.path().empty()) {
        settings[SharedFolder::kVariable] = shared.path();
        // mpirun keeps files of its own under a folder that all runs of a user share and that the last one to end removes, and then one
        // that begins at that moment fails. So each has its own.
        settings["OMPI_MCA_orte_tmpdir_base"] = shared.path();
    }
    std::vector<std::string> result;
    for (char** variable = environ; *variable != nullptr; ++variable) {
        const std::string_view text = *variable;
        if (tells_place_in_another_run(text)) continue;
        // It lies in the folder that the user has chosen.
        if (!shared.path().empty() && text.starts_with(std::string(SharedFolder::kVariable) + "=")) continue;
        settings.erase(std::string(text.substr(0, text.find('='))));
        result.emplace_back(text);
    }
    for (const auto& [name, value] : settings) result.push_back(name + "=" + value);
    return result;
}

std::vector<char*> pointers_to(std::vector<std::string>& texts) {
    std::vector<char*> pointers;
    for (std::string& text : texts) pointers.push_back(text.data());
    pointers.push_back(nullptr);
    return pointers;
}

sigset_t awaited_signals() {
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGCHLD);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP})
        if (!interrupt::is_ignored(signal)) sigaddset(&set, signal);
    return set;
}

// In the child, between fork and exec: only async-signal-safe calls.
[[noreturn]] void become(char* const* arguments, char* const* environment, const sigset_t& mask, pid_t launcher, const Relay& relay) {
    // A separate process group: the terminal's Ctrl-C reaches only the launcher, which decides what to pass on.
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != launcher) _exit(kCannotStart);
    // mpirun must not get an unreadable input either, which runtime/base/files/standard_streams.h installs if there is none.
    if (isatty(STDIN_FILENO) != 0 || (fcntl(STDIN_FILENO, F_GETFL) & O_ACCMODE) == O_WRONLY) {
        const int nothing = open("/dev/null", O_RDONLY);
        if (nothing >= 0) dup2(nothing, STDIN_FILENO);
    }
    relay.enter_child();
    for (const int signal : {SIGCHLD, SIGPIPE}) std::signal(signal, SIG_DFL);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP})
        if (!interrupt::is_ignored(signal)) std::signal(signal, SIG_DFL);
    sigprocmask(SIG_SETMASK, &mask, nullptr);
    execvpe(arguments[0], arguments, environment);
    _exit(kCannotStart);
}

// How mpirun ended, if it has. A child that nobody can wait for could not be started.
std::optional<LaunchOutcome> outcome_of(pid_t child) {
    int status = 0;
    const pid_t ended = waitpid(child, &status, WNOHANG);
    LaunchOutcome outcome;
    if (ended == 0 || (ended < 0 && errno == EINTR)) return std::nullopt;
    if (ended < 0) outcome.exit_code = kCannotStart;
    if (ended == child && WIFEXITED(status)) outcome.exit_code = WEXITSTATUS(status);
    if (ended == child && WIFSIGNALED(status)) {
        outcome.launcher_signal = WTERMSIG(status);
        outcome.exit_code = 128 + outcome.launcher_signal;
    }
    return outcome;
}

// Why the processes are killed although nobody has asked for it, and where they were.
struct Trouble {
    enum class Kind { None, Hung, Lost, MpirunHung } kind = Kind::None;
    Heartbeat::Standing standing = {};
};

Trouble look(Heartbeat& heartbeat, LostProcess& lost_process) {
    using Kind = Trouble::Kind;
    const LostProcess::Sees seen = lost_process.look();
    const Kind kind = seen == LostProcess::Sees::AllEnded  ? Kind::MpirunHung
                      : seen != LostProcess::Sees::Nothing ? Kind::Lost
                      : heartbeat.missed()                 ? Kind::Hung
                                                           : Kind::None;
    if (kind == Kind::None) return {};
    return {kind, heartbeat.standing()};
}

// What becomes of the outcome of mpirun when the processes have been told to end, or have been killed.
LaunchOutcome complete(LaunchOutcome outcome, Shutdown& shutdown, int interrupted_by, const Trouble& trouble, const Heartbeat* heartbeat) {
    outcome.interrupted_by = interrupted_by;
    outcome.told = heartbeat != nullptr && heartbeat->told();
    const bool killed = shutdown.killed();
    if (killed || outcome.exit_code > 128) shutdown.clean_up();
    if (heartbeat != nullptr) outcome.standing = heartbeat->standing();
    if (trouble.kind != Trouble::Kind::None) {
        outcome.standing = trouble.standing;
        outcome.hung = trouble.kind == Trouble::Kind::Hung;
        outcome.lost = trouble.kind == Trouble::Kind::Lost;
        outcome.exit_code = 128 + SIGKILL;
        outcome.launcher_signal = trouble.kind == Trouble::Kind::MpirunHung ? SIGKILL : 0;
        return outcome;
    }
    if (killed) outcome = {.exit_code = 128 + SIGINT, .interrupted_by = interrupted_by, .told = outcome.told};
    // Whatever mpirun makes of processes that it had to end.
    if (shutdown.insisted() && outcome.exit_code != 0) outcome.exit_code = 128 + SIGTERM;
    return outcome;
}

// Waits for the child; hands the user's signals on, and what it writes. The signals are blocked, so none is lost between two looks.
LaunchOutcome wait_for(pid_t child, Shutdown& shutdown, const sigset_t& awaited, Relay& relay, Relay::Input input, Heartbeat* heartbeat) {
    // A session takes kEndWellSignal for Ctrl-C, which does not end it.
    const auto given_as = [&](int signal) { return input == Relay::Input::Typed && signal != SIGINT ? SIGTERM : kEndWellSignal; };
    int interrupted_by = 0;
    std::uint64_t shown_before = 0;
    int looks_unheard = 0;
    LostProcess lost_process(heartbeat == nullptr ? std::span<const liveness::Place>() : heartbeat->places(), child, shutdown.program());
    Trouble trouble;
    while (true) {
        std::optional<LaunchOutcome> outcome = outcome_of(child);
        const timespec at_once = {.tv_sec = 0, .tv_nsec = 0};
        // One that has ended both this process and mpirun is told of, too.
        for (int signal = 0; (signal = sigtimedwait(&awaited, nullptr, &at_once)) > 0;) {
            if (signal == SIGCHLD) continue;
            if (interrupted_by == 0) interrupted_by = signal;
            if (outcome) break;
            if (shutdown.asked())
                shutdown.insist();
            else
                shutdown.ask(given_as(signal));
            shown_before = relay.shown();
        }
        if (outcome) return complete(*outcome, shutdown, interrupted_by, trouble, heartbeat);
        relay.pass(kLookMilliseconds);
        const bool answered = interrupted_by == SIGINT && shutdown.heard() && !shutdown.insisted() && relay.shown() > shown_before;
        if (input == Relay::Input::Typed && answered) {
            interrupted_by = 0;
            shutdown.forget();
        }
        // Nobody hears what the processes say: they end as if the user had asked for it, unless they are at their end anyway. A signal
        // that reaches mpirun while it ends makes it crash.
        if (relay.output_error() != 0 && ++looks_unheard > kLooksUntilToldToEnd) shutdown.ask(given_as(SIGTERM));
        if (heartbeat != nullptr && !shutdown.asked()) {
            trouble = look(*heartbeat, lost_process);
            if (trouble.kind != Trouble::Kind::None) shutdown.kill_now();
        }
        shutdown.look();
    }
}

}  // namespace

LaunchOutcome launch_mpi(int processes, const std::vector<std::string>& command, Heartbeat* heartbeat, Relay::Input typed) {
    MELD_CHECK(processes >= 1 && !command.empty(), "processes = {}, words in the command = {}", processes, command.size());
    // Processes are not bound to cores: a process may have several threads, and other programs run here too. mpirun's own remarks about a
    // failed process are suppressed, because the caller reports it better.
    std::vector<std::string> words = {"mpirun", "--quiet", "--bind-to", "none", "-n", std::to_string(processes)};
    words.insert(words.end(), command.begin(), command.end());
    const SharedFolder shared;
    std::vector<std::string> variables = environment_for(processes, heartbeat, shared);
    const std::vector<char*> arguments = pointers_to(words);
    const std::vector<char*> environment = pointers_to(variables);

    const sigset_t awaited = awaited_signals();
    sigset_t before;
    sigprocmask(SIG_BLOCK, &awaited, &before);
    struct sigaction child_default = {}, child_before = {};
    child_default.sa_handler = SIG_DFL;
    sigaction(SIGCHLD, &child_default, &child_before);

    if (heartbeat != nullptr) heartbeat->begin();
    Relay relay(typed);
    const pid_t launcher = getpid();
    const pid_t child = fork();
    if (child == 0) become(arguments.data(), environment.data(), before, launcher, relay);
    relay.leave_child();
    LaunchOutcome outcome{.exit_code = kCannotStart};
    if (child >= 0) {
        Shutdown shutdown(child, command[0], processes);
        outcome = wait_for(child, shutdown, awaited, relay, typed, heartbeat);
    }
    relay.finish();
    outcome.output_error = relay.output_error();

    sigaction(SIGCHLD, &child_before, nullptr);
    sigprocmask(SIG_SETMASK, &before, nullptr);
    return outcome;
}

std::string describe_launch_failure(int exit_code) {
    switch (exit_code) {
        case 124:
            return "the run exceeded its time limit";
        case 126:
            return "the program to run cannot be executed";
        case kCannotStart:
            return "mpirun cannot be started, or it does not find the program";
        case 128 + SIGKILL:
            return "a process was killed (signal 9), most often because memory ran out";
        case 128 + SIGINT:
            return "the processes were interrupted";
        case 128 + SIGTERM:
            return "the processes were ended by a signal (15)";
        default:
            break;
    }
    const int signal = exit_code - 128;
    if (signal <= 0 || signal >= NSIG) return "";
    const char* description = sigdescr_np(signal);
    if (description == nullptr) return "";
    return fmt::format("a process crashed (signal {}: {})", signal, description);
}

}  // namespace meld::comm
