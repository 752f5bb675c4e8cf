#include "runtime/base/terminal/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>

#include "runtime/base/assert.h"
#include "runtime/base/files/standard_streams.h"
#include "runtime/base/process/stage_clock.h"
#include "runtime/base/terminal/terminal_text.h"

namespace meld {

namespace {

constexpr double kTerminalSeconds = 0.1;
constexpr double kPlainSeconds = 10;
constexpr std::string_view kEraseLine = "\r\x1b[K";

// Guards the pointer and what its Progress shows on the screen.
std::mutex live_mutex;
Progress* live = nullptr;

// The first `columns` characters; a character is a byte that does not continue another one.
std::string_view cut_to(std::string_view text, int columns) {
    int characters = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const bool continues = (static_cast<unsigned char>(text[i]) & 0xc0) == 0x80;
        if (!continues && ++characters > columns) return text.substr(0, i);
    }
    return text;
}

}  // namespace

bool stderr_is_terminal() {
    const char* told = std::getenv(kTerminalVariable);
    return isatty(STDERR_FILENO) != 0 || (told != nullptr && std::string_view(told) == "1");
}

int terminal_columns() {
    winsize size = {};
    if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
    int columns = 0;
    if (const char* told = std::getenv("COLUMNS")) std::from_chars(told, told + std::strlen(told), columns);
    return columns > 0 ? columns : 80;
}

ProgressOutput ProgressOutput::on_stderr() {
    const auto write = [](std::string_view text) { static_cast<void>(print(stderr, text)); };
    return {.write = write, .seconds_now = meld::seconds_now, .terminal = stderr_is_terminal(), .columns = terminal_columns()};
}

ProgressOutput ProgressOutput::nowhere() {
    return {.write = [](std::string_view) {}, .seconds_now = [] { return 0.0; }};
}

Progress::Progress(ProgressOutput output)
    : output_(std::move(output)), next_seconds_(output_.seconds_now() + (output_.terminal ? 0 : kPlainSeconds)) {
    const std::lock_guard lock(live_mutex);
    MELD_CHECK(live == nullptr, "two progress lines at once");
    live = this;
}

Progress::~Progress() {
    clear_progress();
    const std::lock_guard lock(live_mutex);
    live = nullptr;
}

void Progress::update(const std::function<std::string()>& text) {
    const double now = output_.seconds_now();
    if (now < next_seconds_) return;
    next_seconds_ = now + (output_.terminal ? kTerminalSeconds : kPlainSeconds);
    const std::string line = visible(text());
    const std::lock_guard lock(live_mutex);
    show(line);
}

void Progress::show(std::string_view text) {
    if (!output_.terminal) {
        output_.write(std::string(text) + "\n");
        return;
    }
    // The last column stays free: some terminals wrap as soon as it is written.
    output_.write(std::string(kEraseLine) + std::string(cut_to(text, output_.columns - 1)));
    shown_ = true;
}

void Progress::clear() {
    if (shown_) output_.write(kEraseLine);
    shown_ = false;
}

void clear_progress() {
    const std::lock_guard lock(live_mutex);
    if (live != nullptr) live->clear();
}

}  // namespace meld
