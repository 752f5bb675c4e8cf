// What the command line asks to be watched: --watch, --expect and --never.
#pragma once

#include <cstdio>
#include <memory>
#include <string>

#include "runtime/abi/module_abi.h"
#include "runtime/driver/options.h"
#include "runtime/inspect/watches.h"

namespace meld::driver {

// Whether the text of a --watch is a file of rules, and not a body.
bool names_watch_file(const std::string& text);

// Null: nothing. Errors: a file cannot be read; mistakes in it or in a body.
Result<std::unique_ptr<inspect::Watches>> make_watches(const RunOptions& options, const ModuleInfo& module, std::FILE* to);

}  // namespace meld::driver
