// Where the commands of a session come from: lines that somebody types at a prompt, or those of a file, a pipe or another program.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "runtime/ask/debug/line_editor.h"
#include "runtime/base/error.h"

namespace meld::debug {

class Input {
  public:
    // Who gives the commands: a script; somebody at a terminal; or a program, which waits for each answer and writes no comments.
    enum class From { Script, Terminal, Program };
    // Errors: the file cannot be read. An empty path is standard input; a file is a script. What is typed at a terminal of this process
    // can be edited, and is kept for later sessions.
    static Result<Input> open(const std::string& path, From from);

    // Whoever it is goes on after a mistake, and Ctrl-C ends what is being done and not the session.
    bool forgives() const { return from_ != From::Script; }

    // The next line with something in it, without comments, which begin with #; at a terminal also an empty one. Nothing at the end.
    // Errors: the input cannot be read; a signal has asked for the end (interrupted).
    Result<std::optional<std::string>> next(std::string_view prompt);
    // Whether this word is the next line, as far as that has come, or the input is at its end: somebody wants what is being done to end.
    // It does not wait, and the word is gone. Of standard input only.
    bool says(std::string_view word);
    // Of the line that came last: "session.txt:3: ".
    std::string place() const;

    // Where lines are edited; otherwise nobody asks.
    void complete_by(Complete complete) {
        if (editor_) editor_->complete_by(std::move(complete));
    }

  private:
    Result<std::optional<std::string>> edited(const std::string& prompt);
    std::string without_comment(std::string line) const;
    Result<bool> more(std::string_view prompt);
    Result<bool> read();

    std::unique_ptr<LineEditor> editor_;
    std::string name_, text_;
    From from_ = From::Script;
    bool at_end_ = false;
    std::size_t at_ = 0;
    std::uint64_t line_ = 0;
};

}  // namespace meld::debug
