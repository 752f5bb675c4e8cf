#include "runtime/ask/debug/input.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "runtime/ask/debug/line_history.h"
#include "runtime/base/files/input_file.h"
#include "runtime/base/files/standard_streams.h"
#include "runtime/base/process/interrupt.h"

namespace meld::debug {

namespace {

constexpr std::uint64_t kMaxCommands_bytes = std::uint64_t{1} << 26;
constexpr std::size_t kMostLine_bytes = std::size_t{1} << 16;

// Where a comment begins, if one does: not within a string of a question.
std::size_t end_of_command(std::string_view line) {
    bool string = false;
    for (std::size_t i = 0; i < line.size(); ++i) {
        if (line[i] == '"') string = !string;
        if (string && line[i] == '\\') ++i;
        if (!string && line[i] == '#') return i;
    }
    return line.size();
}

}  // namespace

Result<Input> Input::open(const std::string& path, From from) {
    Input input;
    const bool from_file = !path.empty() && path != "-";
    input.name_ = from_file ? path : "standard input";
    if (!from_file) {
        input.from_ = from;
        if (from == From::Terminal) input.editor_ = LineEditor::open(history_path());
        return input;
    }
    Result<std::string> text = read_input(path, kMaxCommands_bytes, InputKind::FileOrPipe);
    if (!text) return tl::unexpected<Error>(text.error());
    input.text_ = std::move(*text);
    input.at_end_ = true;
    return input;
}

// The next line that somebody types here, also an empty one.
Result<std::optional<std::string>> Input::edited(const std::string& prompt) {
    while (true) {
        Result<LineEditor::Typed> typed = editor_->read(prompt);
        if (!typed) return tl::unexpected<Error>(typed.error());
        if (typed->what == LineEditor::Typed::What::Line) {
            ++line_;
            return without_comment(std::move(typed->text));
        }
        // What comes next does not stand behind the prompt.
        if (auto printed = print(stdout, "\n"); !printed) return tl::unexpected<Error>(printed.error());
        if (typed->what == LineEditor::Typed::What::End) return std::nullopt;
        if (!interrupt::forget_request()) return fail("interrupted", "", ExitCode::Interrupted);
    }
}

std::string Input::without_comment(std::string line) const {
    if (from_ != From::Program) line.resize(end_of_command(line));
    const std::size_t last = line.find_last_not_of(" \t\r");
    line.resize(last == std::string::npos ? 0 : last + 1);
    return line;
}

// Reads on; false at the end.
Result<bool> Input::more(std::string_view prompt) {
    while (true) {
        if (interrupt::received() != 0) {
            if (!forgives() || !interrupt::forget_request()) return fail("interrupted", "", ExitCode::Interrupted);
            if (from_ == From::Program) continue;
            // The terminal has dropped what was typed of the line.
            text_.resize(at_);
            if (auto printed = print(stdout, "\n" + std::string(prompt)); !printed) return tl::unexpected<Error>(printed.error());
        }
        pollfd in = {.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
        const int ready = ::poll(&in, 1, kPoll_ms);
        if (ready == 0 || (ready < 0 && errno == EINTR)) continue;
        return read();
    }
}

// What there is; false at the end.
Result<bool> Input::read() {
    std::array<char, 4096> block;
    ssize_t size = 0;
    do size = ::read(STDIN_FILENO, block.data(), block.size());
    while (size < 0 && (errno == EINTR || errno == EAGAIN));
    if (size < 0) return fail(fmt::format("cannot read {}: {}", name_, std::strerror(errno)));
    text_.append(block.data(), static_cast<std::size_t>(size));
    return size > 0;
}

bool Input::says(std::string_view word) {
    pollfd in = {.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
    while (!at_end_ && text_.find('\n', at_) == std::string::npos && ::poll(&in, 1, 0) > 0) {
        text_.erase(0, at_);
        at_ = 0;
        at_end_ = text_.size() > kMostLine_bytes || !read().value_or(false);
    }
    const std::size_t end = text_.find('\n', at_);
    if (end == std::string::npos) return at_end_;
    if (std::string_view(text_).substr(at_, end - at_) != word) return false;
    at_ = end + 1;
    ++line_;
    return true;
}

Result<std::optional<std::string>> Input::next(std::string_view prompt) {
    if (editor_) return edited(std::string(prompt));
    if (from_ == From::Terminal)
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
            if (from_ == From::Terminal) static_cast<void>(print(stdout, "\n"));
            return std::nullopt;
        }
        std::string line = without_comment(text_.substr(at_, end == std::string::npos ? end : end - at_));
        at_ = end == std::string::npos ? text_.size() : end + 1;
        ++line_;
        if (!line.empty() || from_ == From::Terminal) return line;
    }
}

std::string Input::place() const { return fmt::format("{}:{}: ", name_, line_); }

}  // namespace meld::debug
