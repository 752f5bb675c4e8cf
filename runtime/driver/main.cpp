// meldsim: run Meld programs on ensembles of catoms.
#include <CLI/CLI.hpp>
#include <cstdint>
#include <limits>
#include <optional>

#include "runtime/base/error.h"
#include "runtime/base/standard_streams.h"
#include "runtime/cli/command_line.h"
#include "runtime/driver/run.h"
#include "runtime/driver/world_command.h"

namespace {

int run_program(int argc, char** argv) {
    using namespace meld::driver;
    namespace cli = meld::cli;
    RunOptions run;
    run.arguments.assign(argv, argv + argc);
    std::string world_path;

    CLI::App app{"meldsim runs Meld programs on ensembles of catoms.\n\nExample: meldsim run examples/meld/gradient.meld", "meldsim"};
    app.require_subcommand(1);
    app.footer(
        "Exit codes: 0 success, 1 an error in the program, 2 usage or world, 4 limit, memory or disk, 5 an unusable module, 70 a bug of "
        "meldsim, 130 interrupted, 143 terminated.");

    CLI::App* r = app.add_subcommand("run",
                                     "Run a program until nothing is left to do, compiling it if needed.\nExample: meldsim run "
                                     "examples/meld/gradient.meld -n 2 --facts-out gradient.facts");
    r->add_option("PROGRAM", run.program, "The program: a .meld file, or a module that meldc compiled")->required();
    r->add_option("--world", run.world, "The world, a .toml file; the default is the .toml next to PROGRAM, or else a cube of 1,000 catoms")
        ->type_name("FILE");
    r->add_option("-I,--library", run.library_paths, "Search this folder for the program's includes and libraries; repeatable")
        ->type_name("DIR")
        ->take_all()
        ->allow_extra_args(false);
    r->add_option("--ticks", run.ticks, "Stop after this many ticks")
        ->check(cli::whole_number(0, std::numeric_limits<std::int64_t>::max() - 1))
        ->type_name("INT");
    r->add_option("-n,--processes", run.processes, "Number of processes, started through mpirun")
        ->check(cli::whole_number(1, 100000))
        ->capture_default_str();
    r->add_option("--threads", run.threads, "Worker threads in each process")->check(cli::whole_number(1, 1024))->capture_default_str();
    r->add_option("--set", run.set, "Replace the value of a constant of the program; repeatable")
        ->type_name("NAME=VALUE")
        ->take_all()
        ->allow_extra_args(false);
    r->add_option("--arg", run.given, "The value of @arg1 in the program; the next --arg sets @arg2, and so on")
        ->type_name("VALUE")
        ->take_all()
        ->allow_extra_args(false);
    r->add_option("--link", run.link, "A C or C++ file that defines extern functions of the program; repeatable")
        ->type_name("FILE")
        ->take_all()
        ->allow_extra_args(false);
    r->add_option("--extension", run.extensions, "A shared object with components in C++, which the world can choose; repeatable")
        ->type_name("FILE")
        ->take_all()
        ->allow_extra_args(false);
    r->add_option("-O", run.optimisation, "Optimize the module at this level, 0 to 3, as meldc compile does")
        ->check(cli::whole_number(0, 3))
        ->type_name("N");
    r->add_option("--seed", run.seed, "The seed of all random numbers")
        ->check(cli::whole_number(0, std::numeric_limits<std::int64_t>::max() - 1))
        ->type_name("INT");
    r->add_option("--facts-out", run.facts_out,
                  "Write all facts at the end: as text, - for standard output; FOLDER/ for CSV tables; .h5 for HDF5 tables")
        ->type_name("FILE");
    r->add_option("--record", run.record, "Record positions, colours and the world's [record] predicates as VTKHDF")->type_name("FILE");
    r->add_option("--digest", run.digest, "Write a digest of the state after every tick; - for standard output")->type_name("FILE");
    r->add_flag("--strict", run.strict, "End at the first arithmetic error in a view, even if the facts may still change");
    r->add_flag("--sync", run.sync, "Wait after each recorded step, each digest and each file until it is on the disk");
    r->add_flag("--json", run.json, "Print the summary as JSON");
    r->add_flag("--quiet", run.quiet, "Print no progress line and no summary");
    r->add_option("--module", run.module)->group("");

    CLI::App* w = app.add_subcommand(
        "world", "Check a world; print how many catoms it has and where they are.\nExample: meldsim world examples/meld/gradient.toml");
    w->add_option("FILE", world_path, "The world, a .toml file")->required();
    std::vector<std::string> world_extensions;
    w->add_option("--extension", world_extensions, "As for meldsim run; repeatable")
        ->type_name("FILE")
        ->take_all()
        ->allow_extra_args(false);

    cli::add_common(app);
    const cli::Elsewhere elsewhere = {{"check", "meldc"}, {"compile", "meldc"}, {"explain", "meldc"}, {"fmt", "meldc"}, {"lsp", "meldc"}};
    if (const std::optional<int> code = cli::parse(app, argc, argv, {}, elsewhere)) return *code;
    return *r ? run_command(std::move(run)) : world_command(world_path, world_extensions);
}

}  // namespace

int main(int argc, char** argv) {
    meld::prepare_standard_streams();
    return meld::end_standard_output("meldsim", run_program(argc, argv));
}
