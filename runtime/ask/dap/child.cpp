#include "runtime/ask/dap/child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <utility>

namespace meld::dap {

namespace {

using std::chrono::milliseconds;

constexpr milliseconds kEndsByItself{500}, kEndsWhenAsked{2500};

void close_end(int& descriptor) {
    if (descriptor >= 0) ::close(std::exchange(descriptor, -1));
}

// Reading and writing end.
using Pipe = std::array<int, 2>;

[[noreturn]] void become(char* const* words, const std::string& folder, const std::array<int, 3>& streams) {
    for (int i = 0; i < 3; ++i) ::dup2(streams[static_cast<std::size_t>(i)], i);
    if (!folder.empty() && ::chdir(folder.c_str()) != 0) {
        const std::string why = fmt::format("meldsim: cannot enter the folder {}: {}\n", folder, std::strerror(errno));
        static_cast<void>(!::write(STDERR_FILENO, why.data(), why.size()));
        ::_exit(static_cast<int>(ExitCode::UsageOrWorld));
    }
    ::execv("/proc/self/exe", words);
    ::_exit(127);
}

}  // namespace

Result<Child> Child::start(const std::vector<std::string>& words, const std::string& folder) {
    std::array<Pipe, 3> pipes;
    for (Pipe& each : pipes)
        if (::pipe2(each.data(), O_CLOEXEC) != 0) return fail(fmt::format("cannot make a pipe: {}", std::strerror(errno)));
    std::string self = "meldsim";
    std::vector<char*> arguments = {self.data()};
    std::vector<std::string> copies = words;
    for (std::string& word : copies) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const pid_t parent = ::getpid();
    Child child;
    child.process_ = ::fork();
    if (child.process_ == 0) {
        ::prctl(PR_SET_PDEATHSIG, SIGTERM);
        if (::getppid() != parent) ::_exit(127);
        become(arguments.data(), folder, {pipes[0][0], pipes[1][1], pipes[2][1]});
    }
    const int why = errno;
    ::close(pipes[0][0]);
    ::close(pipes[1][1]);
    ::close(pipes[2][1]);
    child.input_ = pipes[0][1];
    child.output_ = pipes[1][0];
    child.errors_ = pipes[2][0];
    if (child.process_ < 0) return fail(fmt::format("cannot start a process: {}", std::strerror(why)));
    return child;
}

Child::Child(Child&& other) noexcept
    : process_(std::exchange(other.process_, -1)),
      input_(std::exchange(other.input_, -1)),
      output_(std::exchange(other.output_, -1)),
      errors_(std::exchange(other.errors_, -1)),
      exit_code_(other.exit_code_) {}

std::string Child::read(int& descriptor) {
    std::string block(1 << 16, '\0');
    ssize_t size = 0;
    do size = ::read(descriptor, block.data(), block.size());
    while (size < 0 && errno == EINTR);
    if (size <= 0) close_end(descriptor);
    block.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
    return block;
}

bool Child::write(std::string_view text) {
    while (!text.empty()) {
        const ssize_t size = input_ < 0 ? -1 : ::write(input_, text.data(), text.size());
        if (size < 0 && errno == EINTR && input_ >= 0) continue;
        if (size <= 0) return false;
        text.remove_prefix(static_cast<std::size_t>(size));
    }
    return true;
}

bool Child::has_ended() {
    if (process_ < 0) return true;
    int status = 0;
    const pid_t ended = ::waitpid(process_, &status, WNOHANG);
    if (ended == 0 || (ended < 0 && errno == EINTR)) return false;
    process_ = -1;
    exit_code_ = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
    return true;
}

// What it still writes is read, so that it is not kept from ending.
bool Child::ends_within(milliseconds time) {
    const auto until = std::chrono::steady_clock::now() + time;
    while (!has_ended() && std::chrono::steady_clock::now() < until) {
        std::array<pollfd, 2> ends = {pollfd{output_, POLLIN, 0}, pollfd{errors_, POLLIN, 0}};
        ::poll(ends.data(), ends.size(), 10);
        if (ends[0].revents != 0) read_output();
        if (ends[1].revents != 0) read_errors();
    }
    return process_ < 0;
}

int Child::end() {
    close_end(input_);
    if (!ends_within(kEndsByItself)) {
        ::kill(process_, SIGTERM);
        if (!ends_within(kEndsWhenAsked)) {
            ::kill(process_, SIGKILL);
            while (!ends_within(kEndsWhenAsked)) {
            }
        }
    }
    close_end(output_);
    close_end(errors_);
    return exit_code_;
}

}  // namespace meld::dap
