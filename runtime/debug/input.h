// Where the commands of a session come from: lines that somebody types at a prompt, or those of a file or a pipe.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "runtime/base/error.h"

namespace meld::debug {

class Input {
  public:
    // Errors: the file cannot be read. An empty path is standard input, which may be typed at a terminal.
    static Result<Input> open(const std::string& path, bool typed);

    // Somebody sits at a terminal: mistakes are told and forgiven, and Ctrl-C ends what is being done and not the session.
    bool is_terminal() const { return terminal_; }

    // The next line with something in it, without comments, which begin with #; at a terminal also an empty one. Nothing at the end.
    // Errors: the input cannot be read; a signal has asked for the end (interrupted).
    Result<std::optional<std::string>> next(std::string_view prompt);
    // Of the line that came last: "session.txt:3: ".
    std::string place() const;

  private:
    Result<bool> more(std::string_view prompt);

    std::string name_, text_;
    bool from_file_ = false, terminal_ = false, at_end_ = false;
    std::size_t at_ = 0;
    std::uint64_t line_ = 0;
};

}  // namespace meld::debug
