// One process that is supervised.
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <ctime>

#include "runtime/base/assert.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/comm/launch/child_processes.h"
#include "runtime/comm/launch/launch.h"

namespace meld::comm {

namespace {

using Clock = std::chrono::steady_clock;

constexpr timespec kBetweenSignals = {.tv_sec = 0, .tv_nsec = 100'000'000};
// From the first order to end until a process that is stopped, and hears nothing, is killed.
constexpr std::chrono::milliseconds kUntilStoppedIsKilled{500};

sigset_t set_of(std::initializer_list<int> signals) {
    sigset_t set;
    sigemptyset(&set);
    for (const int signal : signals)
        if (!interrupt::is_ignored(signal)) sigaddset(&set, signal);
    return set;
}

// Signals wait in the child until it handles them.
[[noreturn]] void become(std::vector<std::string>& words, pid_t parent, sigset_t mask) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(kCannotStart);
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    std::signal(SIGCHLD, SIG_DFL);
    std::signal(SIGPIPE, SIG_DFL);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, kEndWellSignal, kEndNowSignal})
        if (!interrupt::is_ignored(signal)) sigaddset(&mask, signal);
    sigprocmask(SIG_SETMASK, &mask, nullptr);
    execvp(arguments[0], arguments.data());
    _exit(kCannotStart);
}

class Child {
  public:
    Child(pid_t process, Heartbeat& heartbeat) : process_(process), heartbeat_(heartbeat) {}

    LaunchOutcome wait(const sigset_t& awaited) {
        while (true) {
            int status = 0;
            const pid_t ended = waitpid(process_, &status, WNOHANG);
            if (ended == process_) return outcome(status);
            if (ended < 0 && errno != EINTR) return {.exit_code = kCannotStart};
            if (const int signal = sigtimedwait(&awaited, nullptr, &kBetweenSignals); signal > 0 && signal != SIGCHLD) pass_on(signal);
            look();
        }
    }

  private:
    void pass_on(int signal) {
        if (interrupted_by_ == 0) {
            interrupted_by_ = signal;
            asked_at_ = Clock::now();
            kill(process_, kEndWellSignal);
        } else if (!insisted_) {
            insisted_ = true;
            insisted_at_ = Clock::now();
            kill(process_, kEndNowSignal);
        }
    }
    void look() {
        const Clock::time_point now = Clock::now();
        const bool deaf = interrupted_by_ != 0 && now > asked_at_ + kUntilStoppedIsKilled && is_stopped(process_);
        if (deaf || (insisted_ && now > insisted_at_ + kUntilKilled)) kill(process_, SIGKILL);
        if (interrupted_by_ != 0 || hung_ || !heartbeat_.missed()) return;
        hung_ = true;
        hung_at_ = heartbeat_.standing();
        kill(process_, SIGKILL);
    }
    LaunchOutcome outcome(int status) const {
        LaunchOutcome out{.interrupted_by = interrupted_by_, .hung = hung_, .standing = hung_ ? hung_at_ : heartbeat_.standing()};
        out.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
        out.told = heartbeat_.told();
        if (WIFSIGNALED(status) && interrupted_by_ != 0) out.exit_code = 128 + SIGINT;
        return out;
    }

    pid_t process_;
    Heartbeat& heartbeat_;
    int interrupted_by_ = 0;
    bool insisted_ = false, hung_ = false;
    Clock::time_point asked_at_, insisted_at_;
    Heartbeat::Standing hung_at_;
};

}  // namespace

LaunchOutcome launch_alone(const std::vector<std::string>& command, Heartbeat& heartbeat) {
    MELD_CHECK(!command.empty(), "no command");
    std::vector<std::string> words = command;
    const sigset_t awaited = set_of({SIGCHLD, SIGINT, SIGTERM, SIGHUP});
    sigset_t before;
    sigprocmask(SIG_BLOCK, &awaited, &before);
    struct sigaction child_default = {}, child_before = {};
    child_default.sa_handler = SIG_DFL;
    sigaction(SIGCHLD, &child_default, &child_before);
    setenv(liveness::kVariable, heartbeat.place().c_str(), 1);
    heartbeat.begin();
    const pid_t parent = getpid();
    const pid_t child = fork();
    if (child == 0) become(words, parent, before);
    unsetenv(liveness::kVariable);
    const LaunchOutcome outcome = child < 0 ? LaunchOutcome{.exit_code = kCannotStart} : Child(child, heartbeat).wait(awaited);
    sigaction(SIGCHLD, &child_before, nullptr);
    sigprocmask(SIG_SETMASK, &before, nullptr);
    return outcome;
}

}  // namespace meld::comm
