// The one live line at the bottom of a terminal that says how far a run is; plain lines, rarely, where there is no terminal.
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace meld {

// A launcher sets it to "1" for processes whose stderr ends in a terminal but is a pipe.
inline constexpr const char* kTerminalVariable = "CLAYMELD_TERMINAL";

// Whether what this process writes to stderr is seen on a terminal.
bool stderr_is_terminal();
// The width of that terminal; 80 when it cannot be told.
int terminal_columns();

// Where a progress line goes and what time it is, so that tests need neither terminal nor clock.
struct ProgressOutput {
    std::function<void(std::string_view)> write;
    std::function<double()> seconds_now;
    bool terminal = false;
    int columns = 80;

    static ProgressOutput on_stderr();
};

// At most one is alive in a process. Everything is for the thread that made it, but clear_progress, which is for all.
class Progress {
  public:
    explicit Progress(ProgressOutput output = ProgressOutput::on_stderr());
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    // Shows the text if it is time to: ten times a second on a terminal, else every 10 s. The text (one line, UTF-8) is made
    // only then, so this may be called every tick.
    void update(const std::function<std::string()>& text);
    // Takes the line away, until the next update.
    void clear();

  private:
    void show(std::string_view text);

    ProgressOutput output_;
    double next_seconds_;
    bool shown_ = false;
};

// Takes the live line away, if there is one; the log does so before it writes, and so must whoever else writes to a terminal.
void clear_progress();

}  // namespace meld
