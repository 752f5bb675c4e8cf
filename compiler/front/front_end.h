// From text to checked program: shared by `meldc`, the language server, and whoever asks about a run.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "compiler/check/program/program.h"
#include "compiler/diagnostics/diagnostics.h"
#include "compiler/source/source.h"
#include "compiler/syntax/parse.h"

namespace meld::front {

// Adds the prelude to the set, which must be empty: its files come first. Returns their number.
std::uint32_t add_prelude(source::FileSet& files);

// Parses the program in a file of the set with what it includes and the libraries it uses; those of the compiler are added to the options.
struct ParsedProgram {
    syntax::Tree prelude;
    syntax::Tree program;
    std::vector<std::uint32_t> others = {};  // ParseOptions::programs
    check::Worlds worlds = check::Worlds::Undecided;
    std::string lattice = {}, ports = {};  // lint::Place
    bool links_c = false;                  // Program::links_c
    bool acyclic = false;                  // lint::Place::graph
};
ParsedProgram parse_program(source::FileSet& files, std::uint32_t file, std::uint32_t prelude_files, diagnostics::Reporter& report,
                            const syntax::ParseOptions& options);

// Checks it. Items that were read are checked even if others were not: all mistakes are reported in one run. The result is complete only if
// no error was reported.
check::Program check_program(const source::FileSet& files, std::uint32_t file, std::uint32_t prelude_files, ParsedProgram parsed,
                             diagnostics::Reporter& report);

}  // namespace meld::front
