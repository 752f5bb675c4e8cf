// The outcome of a run and of what it was watched for, as the XML that JUnit writes and machines that run tests read.
#pragma once

#include <string>
#include <vector>

#include "runtime/ask/watch/watches.h"
#include "runtime/base/error.h"

namespace meld::driver {

// `ran` is how the run itself went; with an error, what should hold at its end was not looked for. Bytes that are no
// visible text are \x and two digits.
std::string junit(const std::string& program, const Result<void>& ran, double seconds,
                  const std::vector<inspect::Watches::Outcome>& outcomes);

}  // namespace meld::driver
