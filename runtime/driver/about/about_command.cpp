#include "runtime/driver/about/about_command.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>

#include "runtime/base/files/standard_streams.h"
#include "runtime/driver/about/about.h"
#include "runtime/driver/setup/print_error.h"
#include "runtime/results/compare/compare.h"

namespace meld::driver {

namespace {

constexpr const char* kWhatThereIs = "Give a recording, a folder of checkpoints, or a row of a study: study.toml#3";

Result<AboutRun> about_run(const AboutOptions& options, const ParseRun& parse) {
    const std::filesystem::path path = options.run;
    const std::size_t mark = options.run.rfind('#');
    std::error_code error;
    if (!options.row.empty()) return about_row(options.run, options.row, options.folder);
    if (mark != std::string::npos && !std::filesystem::exists(path, error))
        return about_row(options.run.substr(0, mark), options.run.substr(mark + 1), options.folder);
    if (path.extension() == ".toml") return fail(fmt::format("{} is a study, and it has many runs", options.run), "Give a row with --row");
    const Result<compare::Kind> kind = compare::kind_of(options.run);
    if (!kind) return fail(kind.error().problem, kWhatThereIs, kind.error().code);
    if (*kind == compare::Kind::Recording) return about_recording(options.run);
    if (*kind == compare::Kind::Checkpoints) return about_checkpoint(options.run, parse);
    return fail(fmt::format("{} is {}, which does not say of which run", options.run, compare::name_of(*kind)), kWhatThereIs);
}

}  // namespace

CLI::App* add_about(CLI::App& app, AboutOptions& about) {
    CLI::App* a = app.add_subcommand("about",
                                     "Say what a run was: program, world, seed, versions, digest, counts that are the same on any machine, "
                                     "and the one command that makes it again.\nExample: meldsim about run.vtkhdf");
    a->add_option("RUN", about.run, "A recording, a folder of checkpoints, or a row of a study, as study.toml#3")->required();
    a->add_option("--row", about.row, "The row, if RUN is a study")->type_name("ROW");
    a->add_option("-o,--output", about.folder, "The folder of the study's results; otherwise that beside it, STUDY.results")
        ->type_name("DIR");
    CLI::Option* const json = a->add_flag("--json", about.json, "Print it as JSON");
    a->add_flag("--latex", about.latex, "Print a paragraph and a table for a section on methods")->excludes(json);
    return a;
}

int about_command(const AboutOptions& options, const ParseRun& parse) {
    const Result<AboutRun> about = about_run(options, parse);
    if (!about) return print_error(about.error());
    const auto printed = print(stdout, options.json ? about_json(*about) : options.latex ? about_latex(*about) : about_text(*about));
    return printed ? 0 : print_error(printed.error());
}

}  // namespace meld::driver
