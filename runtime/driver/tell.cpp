#include "runtime/driver/tell.h"

#include <fmt/format.h>

#include "runtime/base/progress.h"
#include "runtime/base/standard_streams.h"
#include "runtime/base/visible.h"

namespace meld::driver {

int tell(const Error& error) {
    clear_progress();
    if (!error.problem.empty()) static_cast<void>(print(stderr, fmt::format("meldsim: {}\n", visible(error.message()))));
    return static_cast<int>(error.code);
}

}  // namespace meld::driver
