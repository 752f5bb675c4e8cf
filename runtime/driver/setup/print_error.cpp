#include "runtime/driver/setup/print_error.h"

#include <fmt/format.h>

#include "runtime/base/files/standard_streams.h"
#include "runtime/base/terminal/progress.h"
#include "runtime/base/terminal/terminal_text.h"

namespace meld::driver {

int print_error(const Error& error, std::string_view program) {
    clear_progress();
    if (!error.problem.empty()) static_cast<void>(print(stderr, fmt::format("{}: {}\n", program, visible(error.message()))));
    return static_cast<int>(error.code);
}

}  // namespace meld::driver
