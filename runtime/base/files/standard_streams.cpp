#include "runtime/base/files/standard_streams.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <iostream>

#include "runtime/base/files/output_file.h"
#include "runtime/base/process/liveness.h"

namespace meld {

namespace {

// Whether a failure of standard output has been returned to a caller, who reports it.
std::atomic<bool> told{false};

}  // namespace

void prepare_standard_streams() {
    // Opened in the opposite mode: reading from a write-only descriptor fails, and the reverse. The lowest free number is used.
    for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
        if (fcntl(descriptor, F_GETFD) >= 0) continue;
        static_cast<void>(::open("/dev/null", descriptor == STDIN_FILENO ? O_WRONLY : O_RDONLY));
    }
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
}

Result<void> print(std::FILE* stream, std::string_view text) {
    const liveness::WritesToStream writes;
    errno = 0;
    if (std::fwrite(text.data(), 1, text.size(), stream) == text.size() && std::fflush(stream) == 0) return {};
    const int error = errno != 0 ? errno : EIO;
    if (stream == stdout) told = true;
    return tl::unexpected(cannot_write(stream == stdout ? kStandardOutput : "standard error", error));
}

int end_standard_output(std::string_view program, int code) {
    errno = 0;
    std::cout.flush();
    const bool written = std::fflush(stdout) == 0 && std::cout && std::ferror(stdout) == 0;
    if (written || (told && code != 0)) return code;
    // The reason of an earlier failure is not stored; lost bytes stay lost, so writing one more byte may ask for the reason.
    if (errno == 0 && ::write(STDOUT_FILENO, "\n", 1) == 1) errno = EIO;
    const Error error = cannot_write(kStandardOutput, errno);
    // A failure of standard error cannot be reported anywhere.
    if (!error.problem.empty()) static_cast<void>(print(stderr, fmt::format("{}: {}\n", program, error.message())));
    return code != 0 ? code : static_cast<int>(error.code);
}

}  // namespace meld
