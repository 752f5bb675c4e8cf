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

// Errors: two options name one file, also through links, or one names the file that another writes as standard output. Devices and FIFOs
// may be named several times.
Result<void> check_distinct(std::span<const NamedPath> paths);

}  // namespace meld
