// Messages of the compiler as the commands print them.
#pragma once

#include <string>
#include <vector>

#include "compiler/diagnostics/diagnostics.h"
#include "runtime/base/error.h"

namespace meld::driver {

enum class HowMany { MostSevere, All };

// On standard error, coloured at a terminal: the 50 most severe, and how many there are, unless all are asked for. `path` is the program.
void show_messages(const source::FileSet& files, const std::vector<diagnostics::Diagnostic>& messages, const std::string& path,
                   HowMany how_many);

// Prints an error outside of the program; returns its exit code.
int fail_with(const Error& error);

}  // namespace meld::driver
