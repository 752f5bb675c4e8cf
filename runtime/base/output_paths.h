// The paths of one command, before it does anything: nothing that it reads or writes may be another thing that it writes.
#pragma once

#include <span>
#include <string>

#include "runtime/base/error.h"

namespace meld {

struct NamedPath {
    std::string option;  // As a user knows it: "--record", "the program".
    std::string path;    // "-" is standard output; empty paths are left out.
    enum Use { Read, Written } use = Read;
};

// Errors: two options name one file, through links too, or one of them the standard output of the other. Devices and FIFOs may be
// named several times.
Result<void> check_distinct(std::span<const NamedPath> paths);

}  // namespace meld
