#include "runtime/base/terminal/log.h"

#include <atomic>
#include <cstdio>
#include <mutex>
#include <string>

#include "runtime/base/files/standard_streams.h"
#include "runtime/base/terminal/progress.h"
#include "runtime/base/terminal/terminal_text.h"

namespace meld::log {

namespace {

std::atomic<Level> lowest_level{Level::Info};
std::mutex output_mutex;
// These are guarded by output_mutex.
std::function<void(std::string_view)> chosen_output;
bool few_warnings = false;
int warnings_of_kind = 0;

std::string_view prefix_of(Level level) {
    switch (level) {
        case Level::Debug:
            return "debug: ";
        case Level::Warning:
            return "warning: ";
        case Level::Error:
            return "error: ";
        case Level::Info:
        case Level::Off:
            break;
    }
    return "";
}

// Where standard error takes nothing, nobody can be told.
void write_to_stderr(std::string_view line) { static_cast<void>(print(stderr, line)); }

}  // namespace

void set_level(Level level) { lowest_level.store(level, std::memory_order_relaxed); }
Level level() { return lowest_level.load(std::memory_order_relaxed); }

void set_output(std::function<void(std::string_view)> output) {
    const std::lock_guard lock(output_mutex);
    chosen_output = std::move(output);
}

void write(Level line_level, std::string_view text) {
    if (line_level < level() || line_level == Level::Off) return;
    std::string line(prefix_of(line_level));
    line.append(visible(text)).push_back('\n');
    const std::lock_guard lock(output_mutex);
    if (line_level == Level::Warning && few_warnings && ++warnings_of_kind > kFewWarnings) return;
    clear_progress();
    chosen_output ? chosen_output(line) : write_to_stderr(line);
}

FewWarnings::FewWarnings() {
    const std::lock_guard lock(output_mutex);
    few_warnings = true;
    warnings_of_kind = 0;
}

FewWarnings::~FewWarnings() {
    int more = 0;
    {
        const std::lock_guard lock(output_mutex);
        few_warnings = false;
        more = warnings_of_kind - kFewWarnings;
    }
    if (more > 0) warning("there are {} more warnings like these", more);
}

}  // namespace meld::log
