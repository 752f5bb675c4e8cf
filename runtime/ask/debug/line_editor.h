// Lines that are typed at a terminal: editing, history and completion, by libedit.
//
// The terminal is in another mode only while a line is read. It comes back as it was whatever ends the process then, but for SIGKILL.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/error.h"

namespace meld::debug {

// A signal that comes just before the wait is noticed after so long.
inline constexpr int kPoll_ms = 200;

// What can stand at the end of a line: words that replace what follows the first `begin` bytes of it.
struct Completion {
    std::size_t begin = 0;
    std::vector<std::string> words = {};
    std::string after = {};  // Follows the word if there is only one.
};
// Of a line up to the cursor.
using Complete = std::function<Completion(std::string_view line)>;

class LineEditor {
  public:
    // Nothing if lines cannot be edited here: standard input or output is no terminal, or one that cannot move its cursor. `history` is a
    // file with lines of earlier sessions, which gets those of this one; empty: there is none. There is one editor at a time, used by the
    // main thread.
    static std::unique_ptr<LineEditor> open(const std::string& history);
    ~LineEditor();
    LineEditor(const LineEditor&) = delete;
    LineEditor& operator=(const LineEditor&) = delete;

    struct Typed {
        enum class What { Line, End, Interrupted } what = What::Line;
        std::string text = {};  // Of a line, without its end.
    };
    // Waits for a line. Interrupted: a signal has come (runtime/base/process/interrupt.h), and what was typed is dropped. Errors: the
    // terminal is gone.
    Result<Typed> read(const std::string& prompt);

    void complete_by(Complete complete);

  private:
    struct Terminal;
    explicit LineEditor(std::unique_ptr<Terminal> terminal);

    std::unique_ptr<Terminal> terminal_;
};

}  // namespace meld::debug
