// The pipeline: program text to module, one line per stage; any stage can be the last.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compiler/diagnostics/diagnostics.h"
#include "compiler/plan/plan.h"
#include "compiler/source/source.h"
#include "runtime/base/error.h"

namespace meld::driver {

enum class Stage { Tokens, Tree, Program, Plan, Explain, Cpp, Module };

struct CompileOptions {
    Stage last = Stage::Module;
    std::optional<int> optimisation = {};  // 0 to 3, as in -O2; otherwise the length of the module decides.
    std::string cache_dir = {};            // Empty: the default.
    bool progress = false;                 // Prints a progress line on stderr if compiling takes longer than a second.
    std::vector<std::string> library_paths = {};
    std::vector<std::string> programs = {};  // Files with other programs of the same ensemble.
    check::Worlds worlds = check::Worlds::Undecided;
    bool acyclic = false;  // The facts of `link` lead in no circle.
    // Of the world, for a warning: its lattice, and whose numbers ports have there. Empty: unknown.
    std::string lattice = {}, ports = {};
    plan::PlanOptions plan = {};
    std::vector<std::string> link = {};  // C and C++ files with the program's extern functions.
};

struct Compilation {
    source::FileSet files;
    diagnostics::Reporter report;
    // The printed stage, or the path of the module. Empty if the program has errors; see `report`.
    std::string result;
};

// Compiles the program in a file. Errors outside the program (unreadable file, unwritable cache) are error values; errors in the program
// are in Compilation::report.
Result<void> compile(const std::string& path, const CompileOptions& options, Compilation& out);

// The headers that emitted text includes: include path and text.
std::vector<std::pair<std::string, std::string>> module_headers();

// The stage named by --emit, or nothing.
std::optional<Stage> stage_named(const std::string& name);

}  // namespace meld::driver
