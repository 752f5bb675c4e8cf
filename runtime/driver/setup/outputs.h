// The files that a run writes: checks that they are distinct, and that only this run writes them.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runtime/base/files/output_file.h"
#include "runtime/base/files/output_paths.h"
#include "runtime/driver/setup/options.h"
#include "runtime/results/facts/facts_file.h"

namespace meld::driver {

// The files from which a run is made; `world` is the path of the world, empty if there is none.
std::vector<NamedPath> inputs_of(const RunOptions& options, const std::string& world);

// Of a command that writes one file beside a run. Errors: it is one from which the run is made.
Result<void> check_output(const RunOptions& options, const std::string& world, const std::string& option, const std::string& path);

// A file whose format does not follow from its name.
struct NamedOutput {
    const char* option;  // "--record".
    std::string path;
    const char *what, *ending;  // What is written, "a recording is VTKHDF", and how the names of such files end.
    std::string target;         // Of what else something can be made; empty: of this file.
};

// Errors: the file would be taken for something that another command makes, such as a film.
Result<void> check_name(const NamedOutput& output);

// Errors: two options name one file or one stream; the name of a file promises
// a format in which it is not written.
Result<void> check_outputs(const RunOptions& options, const std::string& world);

// How safe the files are that the run writes.
Durability durability(const RunOptions& options);

struct Outputs {
    std::unique_ptr<record::FactsFile> facts;
    std::optional<OutputFile> digest, profile, junit;
};

// Takes them before the run: nobody should learn at the end of a long one that they cannot be written.
Result<void> open_outputs(const RunOptions& options, const ModuleInfo& module, Outputs& outputs);

// Whether results go to standard output, and everything else to standard error.
bool results_at_standard_output(const RunOptions& options);

}  // namespace meld::driver
