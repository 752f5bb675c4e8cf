#include "runtime/driver/grade/confined.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
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

// In the process of the work.
void be_confined(const std::function<std::string()>& work, const Confines& confines, int said, int answer) {
    dup2(said, STDOUT_FILENO);
    dup2(said, STDERR_FILENO);
    if (chdir(confines.folder.c_str()) != 0) _exit(1);
    cut_network();
    set_limit(RLIMIT_CORE, 0);
    set_limit(RLIMIT_FSIZE, confines.file_bytes);
    // What the answer needs comes on top.
    set_limit(RLIMIT_CPU, static_cast<std::uint64_t>(std::ceil(confines.seconds)) + 1);
    set_limit(RLIMIT_AS, address_space_bytes() + confines.memory);
    const std::string text = work();
    std::fflush(stdout);
    std::fflush(stderr);
    set_limit(RLIMIT_FSIZE, kMostAnswer_bytes);
    write_all(answer, text);
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
    auto process =
        CopiedProcess::start([&](int pipe, int file) { be_confined(work, confines, pipe, file); }, CopiedProcess::Signals::Apart);
    if (!process) return fail(process.error().problem, "Give a smaller --jobs", process.error().code);
    return Confined(std::move(*process), confines);
}

Confined::Confined(CopiedProcess process, const Confines& confines)
    : confines_(confines), process_(std::move(process)), begun_(seconds_now()) {
    fcntl(process_.pipe(), F_SETFL, O_NONBLOCK);
}

void Confined::read_said() {
    char buffer[65536];
    for (ssize_t n = 0; (n = read(process_.pipe(), buffer, sizeof buffer)) > 0;) {
        const std::size_t room = confines_.output - std::min<std::size_t>(confines_.output, end_.said.size());
        end_.said.append(buffer, std::min(static_cast<std::size_t>(n), room));
        if (static_cast<std::size_t>(n) <= room) continue;
        ended_by_us_ = ConfinedEnd::Is::TooMuchOutput;
        return;
    }
}

std::optional<ConfinedEnd> Confined::look() {
    read_said();
    std::optional<CopiedProcess::End> end = process_.ended();
    if (!end) {
        if (!ended_by_us_ && confines_.seconds > 0 && seconds_now() - begun_ > kWallFactor * confines_.seconds + kWallMore_s)
            ended_by_us_ = ConfinedEnd::Is::OutOfTime;
        if (!ended_by_us_) return std::nullopt;
        process_.kill();
        end = process_.end();
    }
    if (!ended_by_us_) read_said();
    const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
    return finish(end->status, seconds(end->used.ru_utime) + seconds(end->used.ru_stime));
}

ConfinedEnd Confined::finish(int status, double seconds) {
    using Is = ConfinedEnd::Is;
    end_.seconds = seconds;
    if (ended_by_us_) {
        end_.is = *ended_by_us_;
    } else if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
        end_.answer = read_from_start(process_.file());
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
