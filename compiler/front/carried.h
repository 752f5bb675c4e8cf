// The program of a module, made again from the sources that the module carries and the compiler's own libraries: nothing is read from disk.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/check/program/program.h"
#include "compiler/diagnostics/diagnostics.h"
#include "compiler/source/source.h"
#include "runtime/base/error.h"

namespace meld::front {

// A body that is asked: typed, or that of a rule in a file.
struct Asked {
    std::string text = {};
    std::string file = {};  // The path of the file with this text; empty: the text is a body.
    std::size_t rule = 0;   // Its number among the rules of the file.
};

// What a module says of the program it was made from: its files, its own first, and which of them each include means.
struct Carried {
    std::vector<check::Program::Source> sources;
    std::uint32_t programs = 1;                          // As in check::Program.
    std::vector<std::optional<std::uint32_t>> includes;  // As in check::Program.
    check::Worlds worlds = check::Worlds::Any;           // As in check::Program.
};

// The program, with a body that is asked about its run as its only question. An empty text asks nothing. Leaves out warnings about the
// program. The result is complete only if no error is reported. Errors: what is asked is not a body.
Result<check::Program> check_carried(source::FileSet& files, const Carried& carried, const Asked& asked, diagnostics::Reporter& report);

}  // namespace meld::front
