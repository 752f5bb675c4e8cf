// The child writes its answer into a pipe and ends without running any of its parent's code for the end.
#include "runtime/world/model/run_in_child.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>
#include <fstream>
#include <new>
#include <utility>

namespace meld::model {
namespace {

constexpr int kAnswered = 0, kThrew = 1, kOutOfMemory = 2;

std::uint64_t address_space_bytes() {
    std::ifstream file("/proc/self/statm");
    std::uint64_t pages = 0;
    file >> pages;
    return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

void limit(int resource, std::uint64_t value) {
    struct rlimit now{};
    if (getrlimit(static_cast<__rlimit_resource_t>(resource), &now) != 0) return;
    now.rlim_cur = std::min<rlim_t>(now.rlim_max, value);
    setrlimit(static_cast<__rlimit_resource_t>(resource), &now);
}

void write_all(int file, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t count = ::write(file, bytes.data(), bytes.size());
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) _exit(kThrew);
        bytes.remove_prefix(static_cast<std::size_t>(count));
    }
}

[[noreturn]] void be_child(const std::function<std::string()>& work, int out, const ChildLimits& limits, std::uint64_t before_bytes) {
    // A crash is the child's own affair: nothing is reported by handlers of the parent, and no core is left.
    for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGINT, SIGTERM, SIGPIPE, SIGXCPU}) ::signal(signal, SIG_DFL);
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_CPU, limits.processor_s);
    limit(RLIMIT_AS, before_bytes + limits.memory_bytes);
    try {
        write_all(out, work());
    } catch (const std::bad_alloc&) {
        _exit(kOutOfMemory);
    } catch (...) {
        _exit(kThrew);
    }
    _exit(kAnswered);
}

// Whether it all came.
bool read_all(int file, std::uint64_t most_bytes, std::string& out) {
    std::array<char, 1 << 16> block;
    while (true) {
        const ssize_t count = ::read(file, block.data(), block.size());
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return count == 0;
        out.append(block.data(), static_cast<std::size_t>(count));
        if (out.size() > most_bytes) return false;
    }
}

std::string reason(int status) {
    if (WIFSIGNALED(status)) {
        if (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL) return "reading it takes too long";
        return fmt::format("its reader crashed, {}", strsignal(WTERMSIG(status)));
    }
    return WEXITSTATUS(status) == kOutOfMemory ? "reading it takes too much memory" : "its reader gave up";
}

}  // namespace

Result<std::string> run_in_child(const std::function<std::string()>& work, const std::string& crashed, const ChildLimits& limits) {
    const std::uint64_t before_bytes = address_space_bytes();
    std::array<int, 2> ends{};
    if (::pipe(ends.data()) != 0) return fail(fmt::format("{}: there is no pipe to its reader ({})", crashed, std::strerror(errno)));
    const pid_t child = ::fork();
    if (child < 0) {
        const int error = errno;
        ::close(ends[0]);
        ::close(ends[1]);
        return fail(fmt::format("{}: its reader cannot be started ({})", crashed, std::strerror(error)));
    }
    if (child == 0) {
        ::close(ends[0]);
        be_child(work, ends[1], limits, before_bytes);
    }
    ::close(ends[1]);
    std::string answer;
    const bool whole = read_all(ends[0], limits.answer_bytes, answer);
    ::close(ends[0]);
    if (!whole) ::kill(child, SIGKILL);
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (!whole) return fail(fmt::format("{}: it is too large", crashed));
    if (WIFEXITED(status) && WEXITSTATUS(status) == kAnswered) return answer;
    return fail(fmt::format("{}: {}", crashed, reason(status)), "repair it, or save it in another format, for example as binary STL");
}

}  // namespace meld::model
