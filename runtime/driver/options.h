// The options of `meldsim run`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace meld::driver {

struct RunOptions {
    std::string program = {};                     // A .meld file, or a compiled .so.
    std::string world = {};                       // Empty: PROGRAM.toml if it exists, otherwise a cube of 1,000 catoms.
    std::vector<std::string> library_paths = {};  // For the program's includes and libraries.
    std::int64_t ticks = -1;
    int processes = 1;
    int threads = 1;
    std::int64_t seed = -1;
    std::vector<std::string> set = {};         // name=value
    std::vector<std::string> link = {};        // C files with extern functions.
    std::optional<int> optimisation = {};      // Of the module, 0 to 3; otherwise meldc decides.
    std::vector<std::string> given = {};       // Values of @arg1, @arg2, ...
    std::vector<std::string> extensions = {};  // Shared objects that add implementations of components.
    std::string facts_out = {};
    std::string record = {};
    std::string digest = {};  // A file, or "-" for standard output.
    bool sync = false;        // Files survive a stop of the machine.
    std::string module = {};  // Passed to the processes by the command that started them.
    bool strict = false;
    bool json = false;
    bool quiet = false;
    std::vector<std::string> arguments = {};  // As typed, for the recording and for the processes.
};

}  // namespace meld::driver
