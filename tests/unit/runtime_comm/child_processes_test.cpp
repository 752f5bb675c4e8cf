#include "runtime/comm/launch/child_processes.h"

#include <gtest/gtest.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

namespace meld::comm {
namespace {

// A child that stops at once, under a debugger or not.
class Stopped {
  public:
    explicit Stopped(bool traced) : child_(fork()) {
        if (child_ == 0) {
            if (traced) ptrace(PTRACE_TRACEME, 0, nullptr, nullptr);
            raise(SIGSTOP);
            for (;;) pause();
        }
        int status = 0;
        waitpid(child_, &status, WUNTRACED);
        EXPECT_TRUE(WIFSTOPPED(status));
    }
    ~Stopped() {
        kill(child_, SIGKILL);
        waitpid(child_, nullptr, 0);
    }
    Stopped(const Stopped&) = delete;
    Stopped& operator=(const Stopped&) = delete;
    pid_t process() const { return child_; }

  private:
    pid_t child_;
};

TEST(ChildProcesses, IsStoppedBySignalsAndDebuggers) {
    EXPECT_TRUE(is_stopped(Stopped(false).process()));
    EXPECT_TRUE(is_stopped(Stopped(true).process()));
    EXPECT_FALSE(is_stopped(getpid()));
}

}  // namespace
}  // namespace meld::comm
