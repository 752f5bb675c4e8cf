#include "runtime/debug/input.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "runtime/base/input_file.h"
#include "runtime/base/interrupt.h"
#include "runtime/base/standard_streams.h"

namespace meld::debug {

namespace {

constexpr std::uint64_t kMostFile_bytes = std::uint64_t{1} << 26;
constexpr std::size_t kMostLine_bytes = std::size_t{1} << 16;
// A signal that comes just before the wait is noticed after so long.
constexpr int kLook_ms = 200;

}  // namespace

Result<Input> Input::open(const std::string& path, bool typed) {
    Input input;
    input.from_file_ = !path.empty() && path != "-";
    input.name_ = input.from_file_ ? path : "standard input";
    if (!input.from_file_) {
        input.terminal_ = typed;
        return input;
    }
    Result<std::string> text = read_input(path, kMostFile_bytes, InputKind::FileOrPipe);
    if (!text) return tl::unexpected<Error>(text.error());
    input.text_ = std::move(*text);
    input.at_end_ = true;
    return input;
}

// Reads on; false at the end.
Result<bool> Input::more(std::string_view prompt) {
    while (true) {
        if (interrupt::received() != 0) {
            if (!terminal_ || !interrupt::forget_request()) return fail("interrupted", "", ExitCode::Interrupted);
            // The terminal has dropped what was typed of the line.
            text_.resize(at_);
            if (auto printed = print(stdout, "\n" + std::string(prompt)); !printed) return tl::unexpected<Error>(printed.error());
        }
        pollfd in = {.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
        const int ready = ::poll(&in, 1, kLook_ms);
        if (ready == 0 || (ready < 0 && errno == EINTR)) continue;
        std::array<char, 4096> block;
        const ssize_t size = ready < 0 ? -1 : ::read(STDIN_FILENO, block.data(), block.size());
        if (size < 0 && (errno == EINTR || errno == EAGAIN)) continue;
        if (size < 0) return fail(fmt::format("cannot read {}: {}", name_, std::strerror(errno)));
        text_.append(block.data(), static_cast<std::size_t>(size));
        return size > 0;
    }
}

Result<std::optional<std::string>> Input::next(std::string_view prompt) {
    if (terminal_)
        if (auto printed = print(stdout, prompt); !printed) return tl::unexpected<Error>(printed.error());
    while (true) {
        const std::size_t end = text_.find('\n', at_);
        if (end == std::string::npos && !at_end_) {
            text_.erase(0, at_);
            at_ = 0;
            if (text_.size() > kMostLine_bytes) return fail(fmt::format("{}:{}: the line is too long", name_, line_ + 1));
            const Result<bool> read = more(prompt);
            if (!read) return tl::unexpected<Error>(read.error());
            at_end_ = !*read;
            continue;
        }
        if (end == std::string::npos && at_ >= text_.size()) {
            // The prompt stays alone on its line otherwise.
            if (terminal_) static_cast<void>(print(stdout, "\n"));
            return std::nullopt;
        }
        std::string line = text_.substr(at_, end == std::string::npos ? end : end - at_);
        at_ = end == std::string::npos ? text_.size() : end + 1;
        ++line_;
        if (const std::size_t comment = line.find('#'); comment != std::string::npos) line.resize(comment);
        const std::size_t last = line.find_last_not_of(" \t\r");
        line.resize(last == std::string::npos ? 0 : last + 1);
        if (!line.empty() || terminal_) return line;
    }
}

std::string Input::place() const { return fmt::format("{}:{}: ", name_, line_); }

}  // namespace meld::debug
