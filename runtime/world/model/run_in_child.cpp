#include "runtime/world/model/run_in_child.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>
#include <new>
#include <utility>

#include "runtime/base/process/copied_process.h"

namespace meld::model {
namespace {

constexpr int kAnswered = 0, kThrew = 1, kOutOfMemory = 2;

void be_child(const std::function<std::string()>& work, int out, const ChildLimits& limits, std::uint64_t before_bytes) {
    // A crash is the child's own affair: nothing is reported by handlers of the parent, and no core is left.
    for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGINT, SIGTERM, SIGPIPE, SIGXCPU}) ::signal(signal, SIG_DFL);
    set_limit(RLIMIT_CORE, 0);
    set_limit(RLIMIT_CPU, limits.processor_s);
    set_limit(RLIMIT_AS, before_bytes + limits.memory_bytes);
    try {
        if (!write_all(out, work())) _exit(kThrew);
    } catch (const std::bad_alloc&) {
        _exit(kOutOfMemory);
    } catch (...) {
        _exit(kThrew);
    }
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
    auto child = CopiedProcess::start([&](int out, int) { be_child(work, out, limits, before_bytes); }, CopiedProcess::Signals::Shared);
    if (!child) return fail(fmt::format("{}: its reader does not start: {}", crashed, child.error().problem));
    std::string answer;
    const bool whole = read_all(child->pipe(), limits.answer_bytes, answer);
    if (!whole) child->kill();
    const int status = child->end().status;
    if (!whole) return fail(fmt::format("{}: it is too large", crashed));
    if (WIFEXITED(status) && WEXITSTATUS(status) == kAnswered) return answer;
    return fail(fmt::format("{}: {}", crashed, reason(status)), "repair it, or save it in another format, for example as binary STL");
}

}  // namespace meld::model
