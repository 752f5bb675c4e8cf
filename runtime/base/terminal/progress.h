// The one live line at the bottom of a terminal that shows how far a run is; without a terminal, plain lines at long intervals.
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace meld {

// A launcher sets it to "1" for processes whose stderr is a pipe that ends in a terminal.
inline constexpr const char* kTerminalVariable = "CLAYMELD_TERMINAL";

// Whether the stderr of this process is shown on a terminal.
bool stderr_is_terminal();
// The width of that terminal; 80 if it is unknown.
int terminal_columns();

// Where a progress line goes and what time it is, so that tests need neither terminal nor clock.
struct ProgressOutput {
    std::function<void(std::string_view)> write;
    std::function<double()> seconds_now;
    bool terminal = false;
    int columns = 80;

    static ProgressOutput on_stderr();
    // For those who want to see nothing.
    static ProgressOutput nowhere();
};

// At most one exists in a process. Only the thread that made it may use it, except for clear_progress.
class Progress {
  public:
    explicit Progress(ProgressOutput output = ProgressOutput::on_stderr());
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    // Shows the text if it is time to: ten times a second on a terminal, otherwise every 10 s. The text (one line, UTF-8) is made only
    // then, so this may be called every tick.
    void update(const std::function<std::string()>& text);
    // Removes the line until the next update.
    void clear();

  private:
    void show(std::string_view text);

    ProgressOutput output_;
    double next_seconds_;
    bool shown_ = false;
};

// Removes the live line, if there is one; the log calls it before it writes, and so must all other code that writes to a terminal.
void clear_progress();

}  // namespace meld
