// What a client says of the run that it wants to walk through: the attributes of `launch`, as a command line of `meldsim debug`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "runtime/ask/dap/message.h"

namespace meld::dap {

struct Launch {
    std::string program = {};             // A program, a recording or a folder of checkpoints; absolute.
    std::vector<std::string> words = {};  // Of the command line, behind `meldsim`.
    std::string folder = {};              // In which it is started; empty: that of the adapter.
    std::uint64_t catom = 0;              // Whose facts are shown first.
    bool stop_on_entry = true;
    bool debug = true;  // Otherwise it is only run.
};

// Attributes that are not known are those of the client itself. Errors: one is missing or of the wrong kind.
Result<Launch> read_launch(const Json& arguments);

}  // namespace meld::dap
