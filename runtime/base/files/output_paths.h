// Checks the paths of one command before it starts: no output may be the same as an input or another output.
#pragma once

#include <span>
#include <string>

#include "runtime/base/error.h"

namespace meld {

struct NamedPath {
    std::string option;  // Its name for users: "--record", "the program".
    std::string path;    // "-" is standard output; empty paths are ignored.
    enum Use { Read, Written } use = Read;
};

// Whether what is written to this path goes where standard output goes: "-", a name of its descriptor, the file or pipe it is
// redirected to.
bool is_standard_output(const std::string& path);

// Errors: two options name one file, through links too, or one of them the standard output of the other. Devices and FIFOs may be
// named several times.
Result<void> check_distinct(std::span<const NamedPath> paths);

}  // namespace meld
