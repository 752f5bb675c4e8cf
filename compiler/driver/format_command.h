// `meldc fmt`: formats program files.
#pragma once

#include <string>
#include <vector>

namespace meld::driver {

struct FormatOptions {
    // Paths; `-` is standard input, whose result goes to standard output.
    std::vector<std::string> files = {};
    // Changes nothing, and lists the files that would change.
    bool check = false;
    // Prints the results instead of writing them back.
    bool to_stdout = false;
};

// Returns the exit code: 1 if a file is not a program, or with `check` if one would change; 2 if one cannot be read or written.
int run_format(const FormatOptions& options);

}  // namespace meld::driver
