// Remarks to the user on stderr, one line each: "warning: the text". Diagnostics of programs and results are not remarks.
#pragma once

#include <fmt/format.h>

#include <functional>
#include <string_view>
#include <utility>

namespace meld::log {

enum class Level { Debug, Info, Warning, Error, Off };

// Lines below this level are dropped; Info at the start. All processes but one set Off, so that nothing is printed twice.
void set_level(Level level);
Level level();

// Where lines go, each with its newline; empty: to stderr. For tests and for the viewer.
void set_output(std::function<void(std::string_view)> output);

// Writes one line, after clearing the progress line. Any thread may call it; lines do not mix.
void write(Level level, std::string_view text);

template <class... Arguments>
void debug(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    if (level() <= Level::Debug) write(Level::Debug, fmt::format(format, std::forward<Arguments>(arguments)...));
}
template <class... Arguments>
void info(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    if (level() <= Level::Info) write(Level::Info, fmt::format(format, std::forward<Arguments>(arguments)...));
}
template <class... Arguments>
void warning(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    if (level() <= Level::Warning) write(Level::Warning, fmt::format(format, std::forward<Arguments>(arguments)...));
}
template <class... Arguments>
void error(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    if (level() <= Level::Error) write(Level::Error, fmt::format(format, std::forward<Arguments>(arguments)...));
}

// While it lives, warnings are of one kind and may be many, as those of each line of a world: the first kFewWarnings of them are written,
// and at its end how many more there were. One at a time.
inline constexpr int kFewWarnings = 20;
class FewWarnings {
  public:
    FewWarnings();
    ~FewWarnings();
    FewWarnings(const FewWarnings&) = delete;
    FewWarnings& operator=(const FewWarnings&) = delete;
};

}  // namespace meld::log
