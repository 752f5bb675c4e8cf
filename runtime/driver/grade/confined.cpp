#include "runtime/driver/grade/confined.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <string_view>
#include <utility>

#include "runtime/base/process/stage_clock.h"

namespace meld::driver {

namespace {

// A process waits for others, so that by the clock on the wall it may take longer than it works: so many times, and some seconds.
constexpr double kWallFactor = 4, kWallMore_s = 10;
constexpr std::size_t kMostAnswer_bytes = std::size_t{64} << 20;

void write_text(const char* path, const std::string& text) {
    const int file = open(path, O_WRONLY | O_CLOEXEC);
    if (file < 0) return;
    static_cast<void>(!write(file, text.data(), text.size()));
    close(file);
}

// In the child. Whoever is not root needs a namespace of users, in which it stays who it is.
bool cut_network() {
    if (unshare(CLONE_NEWNET) == 0) return true;
    const uid_t user = geteuid();
    const gid_t group = getegid();
    if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return false;
    write_text("/proc/self/setgroups", "deny");
    write_text("/proc/self/uid_map", fmt::format("{0} {0} 1", user));
    write_text("/proc/self/gid_map", fmt::format("{0} {0} 1", group));
    return true;
}

void limit(decltype(RLIMIT_CPU) what, std::uint64_t most) {
    rlimit now{};
    if (getrlimit(what, &now) != 0) return;
    now.rlim_cur = std::min<rlim_t>(now.rlim_max, most);
    setrlimit(what, &now);
}

// The address space that this process has.
std::uint64_t address_space() {
    std::uint64_t pages = 0;
    if (std::FILE* const file = std::fopen("/proc/self/statm", "re")) {
        if (std::fscanf(file, "%lu", &pages) != 1) pages = 0;
        std::fclose(file);
    }
    return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

// Never returns.
[[noreturn]] void be_confined(const std::function<std::string()>& work, const Confines& confines, int said, int answer, pid_t parent) {
    // It ends with the process that wants its answer; a signal that is meant for that does not reach it.
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(1);
    setpgid(0, 0);
    if (const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC); nothing >= 0) dup2(nothing, STDIN_FILENO);
    dup2(said, STDOUT_FILENO);
    dup2(said, STDERR_FILENO);
    if (chdir(confines.folder.c_str()) != 0) _exit(1);
    cut_network();
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_FSIZE, confines.file_bytes);
    // What the answer needs comes on top.
    limit(RLIMIT_CPU, static_cast<std::uint64_t>(std::ceil(confines.seconds)) + 1);
    limit(RLIMIT_AS, address_space() + confines.memory);
    const std::string text = work();
    std::fflush(stdout);
    std::fflush(stderr);
    limit(RLIMIT_FSIZE, kMostAnswer_bytes);
    for (std::size_t at = 0; at < text.size();) {
        const ssize_t n = write(answer, text.data() + at, text.size() - at);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) break;
        at += static_cast<std::size_t>(n);
    }
    _exit(0);
}

}  // namespace

bool can_cut_network() {
    std::fflush(nullptr);
    const pid_t child = fork();
    if (child == 0) _exit(cut_network() ? 0 : 1);
    int status = 0;
    while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    return child > 0 && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

Result<Confined> Confined::start(const std::function<std::string()>& work, const Confines& confines) {
    Confined run;
    run.confines_ = confines;
    run.begun_ = seconds_now();
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) return fail(fmt::format("cannot make a pipe: {}", std::strerror(errno)), "", ExitCode::LimitHit);
    run.said_ = ends[0];
    fcntl(run.said_, F_SETFL, O_NONBLOCK);
    run.answer_ = memfd_create("answer", MFD_CLOEXEC);
    std::fflush(nullptr);
    const pid_t parent = getpid();
    run.process_ = fork();
    if (run.process_ == 0) be_confined(work, confines, ends[1], run.answer_, parent);
    const int error = errno;
    close(ends[1]);
    if (run.process_ < 0)
        return fail(fmt::format("cannot start a process: {}", std::strerror(error)), "Give a smaller --jobs", ExitCode::LimitHit);
    setpgid(run.process_, run.process_);
    return run;
}

Confined::Confined(Confined&& other) noexcept { *this = std::move(other); }

Confined& Confined::operator=(Confined&& other) noexcept {
    std::swap(confines_, other.confines_);
    std::swap(process_, other.process_);
    std::swap(said_, other.said_);
    std::swap(answer_, other.answer_);
    std::swap(begun_, other.begun_);
    std::swap(ended_by_us_, other.ended_by_us_);
    std::swap(end_, other.end_);
    return *this;
}

Confined::~Confined() {
    if (process_ > 0) {
        kill(-process_, SIGKILL);
        while (waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
        }
    }
    if (said_ >= 0) close(said_);
    if (answer_ >= 0) close(answer_);
}

void Confined::read_said() {
    char buffer[65536];
    for (ssize_t n = 0; (n = read(said_, buffer, sizeof buffer)) > 0;) {
        const std::size_t room = confines_.output - std::min<std::size_t>(confines_.output, end_.said.size());
        end_.said.append(buffer, std::min(static_cast<std::size_t>(n), room));
        if (static_cast<std::size_t>(n) <= room) continue;
        ended_by_us_ = ConfinedEnd::Is::TooMuchOutput;
        return;
    }
}

std::optional<ConfinedEnd> Confined::look() {
    read_said();
    int status = 0;
    rusage used{};
    pid_t ended = wait4(process_, &status, WNOHANG, &used);
    if (ended == 0) {
        if (!ended_by_us_ && confines_.seconds > 0 && seconds_now() - begun_ > kWallFactor * confines_.seconds + kWallMore_s)
            ended_by_us_ = ConfinedEnd::Is::OutOfTime;
        if (!ended_by_us_) return std::nullopt;
        kill(-process_, SIGKILL);
        while ((ended = wait4(process_, &status, 0, &used)) < 0 && errno == EINTR) {
        }
    }
    // What it has started and left.
    kill(-process_, SIGKILL);
    process_ = 0;
    if (!ended_by_us_) read_said();
    const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
    return finish(status, seconds(used.ru_utime) + seconds(used.ru_stime));
}

ConfinedEnd Confined::finish(int status, double seconds) {
    using Is = ConfinedEnd::Is;
    end_.seconds = seconds;
    if (ended_by_us_) {
        end_.is = *ended_by_us_;
    } else if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
        char buffer[65536];
        off_t at = 0;
        for (ssize_t n = 0; (n = pread(answer_, buffer, sizeof buffer, at)) > 0; at += n)
            end_.answer.append(buffer, static_cast<std::size_t>(n));
        end_.is = Is::Answered;
    } else if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) {
        end_.is = Is::OutOfTime;
    } else if (WIFEXITED(status) && WEXITSTATUS(status) == static_cast<int>(ExitCode::LimitHit)) {
        // There is one limit at which a process ends itself; runtime/base/process/deep_stack.h.
        end_.is = Is::OutOfMemory;
    } else {
        end_.how = WIFSIGNALED(status) ? fmt::format("signal {}", WTERMSIG(status)) : fmt::format("exit code {}", WEXITSTATUS(status));
    }
    return std::move(end_);
}

}  // namespace meld::driver
