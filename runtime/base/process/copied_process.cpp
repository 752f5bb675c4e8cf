#include "runtime/base/process/copied_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <utility>

namespace meld {

namespace {

[[noreturn]] void be_copy(const CopiedProcess::Work& work, CopiedProcess::Signals signals, int pipe, int file, pid_t parent) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(1);
    if (signals == CopiedProcess::Signals::Apart) setpgid(0, 0);
    if (const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC); nothing >= 0) dup2(nothing, STDIN_FILENO);
    work(pipe, file);
    // None of this process's code for the end runs twice.
    _exit(0);
}

}  // namespace

bool write_all(int descriptor, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t n = write(descriptor, bytes.data(), bytes.size());
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return false;
        bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    return true;
}

std::string read_from_start(int descriptor) {
    std::string all;
    char buffer[65536];
    off_t at = 0;
    for (ssize_t n = 0; (n = pread(descriptor, buffer, sizeof buffer, at)) > 0; at += n) all.append(buffer, static_cast<std::size_t>(n));
    return all;
}

std::uint64_t address_space_bytes() {
    std::ifstream file("/proc/self/statm");
    std::uint64_t pages = 0;
    file >> pages;
    return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

void set_limit(int resource, std::uint64_t most) {
    const auto what = static_cast<__rlimit_resource_t>(resource);
    rlimit now{};
    if (getrlimit(what, &now) != 0) return;
    now.rlim_cur = std::min<rlim_t>(now.rlim_max, most);
    setrlimit(what, &now);
}

Result<CopiedProcess> CopiedProcess::start(const Work& work, Signals signals) {
    CopiedProcess copy;
    copy.signals_ = signals;
    const auto failed = [](const char* what) {
        return fail(fmt::format("cannot {}: {}", what, std::strerror(errno)), "", ExitCode::LimitHit);
    };
    copy.file_ = memfd_create("answer", MFD_CLOEXEC);
    if (copy.file_ < 0) return failed("make a file in memory");
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) return failed("make a pipe");
    copy.pipe_ = ends[0];
    std::fflush(nullptr);
    const pid_t parent = getpid();
    copy.process_ = fork();
    if (copy.process_ == 0) be_copy(work, signals, ends[1], copy.file_, parent);
    const int error = errno;
    close(ends[1]);
    errno = error;
    if (copy.process_ < 0) return failed("start a process");
    // Whoever comes first: this process may want to end it before it has run at all.
    if (signals == Signals::Apart) setpgid(copy.process_, copy.process_);
    return copy;
}

CopiedProcess::CopiedProcess(CopiedProcess&& other) noexcept { *this = std::move(other); }

CopiedProcess& CopiedProcess::operator=(CopiedProcess&& other) noexcept {
    std::swap(signals_, other.signals_);
    std::swap(process_, other.process_);
    std::swap(pipe_, other.pipe_);
    std::swap(file_, other.file_);
    return *this;
}

CopiedProcess::~CopiedProcess() {
    if (process_ > 0) {
        kill();
        end();
    }
    if (pipe_ >= 0) close(pipe_);
    if (file_ >= 0) close(file_);
}

void CopiedProcess::kill() {
    if (process_ > 0) ::kill(whom(), SIGKILL);
}

std::optional<CopiedProcess::End> CopiedProcess::wait(bool until_it_ends) {
    End end;
    pid_t ended = 0;
    while ((ended = wait4(process_, &end.status, until_it_ends ? 0 : WNOHANG, &end.used)) < 0 && errno == EINTR) {
    }
    if (ended == 0) return std::nullopt;
    // What it has started and left.
    if (signals_ == Signals::Apart) kill();
    process_ = 0;
    return end;
}

}  // namespace meld
