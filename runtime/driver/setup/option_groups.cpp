#include "runtime/driver/setup/option_groups.h"

namespace meld::driver {

CLI::Option* add_list(CLI::App& command, const std::string& name, std::vector<std::string>& values, const char* type, const char* text) {
    return command.add_option(name, values, text)->type_name(type)->take_all()->allow_extra_args(false);
}

void add_inputs(CLI::App& command, RunOptions& run, const char* world) {
    command.add_option("--world", run.world, world)->type_name("FILE");
    add_list(command, "--events", run.events, "FILE",
             "Further [[event]] tables for the world, such as save-events of the debugger has written; repeatable");
    add_list(command, "-I,--library", run.library_paths, "DIR", "Search this folder for the program's includes and libraries; repeatable");
    add_list(command, "--set", run.set, "NAME=VALUE", "Replace the value of a constant of the program; repeatable");
    add_list(command, "--arg", run.given, "VALUE", "The value of @arg1 in the program; the next --arg sets @arg2, and so on");
    add_list(command, "--link", run.link, "FILE", "A C or C++ file that defines extern functions of the program; repeatable");
    add_list(command, "--extension", run.extensions, "FILE",
             "A shared object with components in C++, which the world can choose; repeatable");
    command.add_option("-O", run.optimisation, "Optimize the module at this level, 0 to 3, as meldc compile does")
        ->check(cli::whole_number(0, 3))
        ->type_name("N");
    command.add_option("--seed", run.seed, "The seed of all random numbers")
        ->check(cli::whole_number(0, std::numeric_limits<std::int64_t>::max() - 1))
        ->type_name("INT");
    command
        .add_option("--ports", run.ports,
                    "Number the sides of catoms as this robot does, for whose modules the program was written: blinky, "
                    "blinky-visiblesim, smartblocks, catoms2d, catoms3d; or lattice")
        ->type_name("ROBOT");
    command.add_flag("--by-links", run.by_links, "Find neighbours in a table of links, as graphs do; results do not change");
    command.add_flag("--strict", run.strict, "End at the first arithmetic error in a view, even if the facts may still change");
}

CLI::Option* add_program(CLI::App& command, RunOptions& run) {
    CLI::Option* const program =
        command.add_option("PROGRAM", run.program, "The program: a .meld file, or a module that meldc compiled")->required();
    add_inputs(command, run, "The world, a .toml file; the default is the .toml next to PROGRAM, or else a cube of 1,000 catoms");
    add_ticks(command, run.ticks, "Stop after this many ticks");
    add_processes(command, run.processes, run.threads);
    return program;
}

void add_outputs(CLI::App& command, RunOptions& run) {
    command
        .add_option("--facts-out", run.facts_out,
                    "Write all facts at the end: as text, - for standard output; FOLDER/ for CSV tables; .h5 for HDF5 tables")
        ->type_name("FILE");
    add_list(
        command, "--limit", run.limits, "NAME=VALUE",
        "Replace a limit of the world: facts (of one predicate at a catom), derivations (of a catom in a tick), ticks, list (elements) or "
        "memory; repeatable");
    command.add_option("--record", run.record, "Record positions, colours and the world's [record] predicates as VTKHDF")
        ->type_name("FILE");
    CLI::Option* const digest =
        command.add_option("--digest", run.digest, "Write a digest of the state after every tick; - for standard output")
            ->type_name("FILE");
    command
        .add_option("--digest-check", run.digest_check,
                    "In every so many ticks compare the digest, which is kept by changes, with one of the whole state")
        ->check(CLI::Range(std::int64_t{1}, std::int64_t{1} << 62).description(""))
        ->type_name("TICKS")
        ->needs(digest);
    CLI::Option* const checkpoint =
        command
            .add_option("--checkpoint", run.checkpoint,
                        "Keep checkpoints in this folder, from which meldsim resume goes on: now and then, at Ctrl-C, and at the end")
            ->type_name("DIR");
    command.add_option("--checkpoint-every", run.checkpoint_every, "How often: a time such as 30s, or 1000ticks")
        ->type_name("INTERVAL")
        ->capture_default_str();
    command
        .add_flag("--checkpoint-changes", run.checkpoint_changes,
                  "Write what has changed since the last checkpoint, and everything only now and then")
        ->needs(checkpoint);
    add_supervision(command, run.retries, run.heartbeat, "With --checkpoint: how", "With --checkpoint: a");
    add_list(command, "--watch", run.watch, "BODY",
             "Stop after the tick in which this body, in Meld, begins to hold, with exit code 3; or FILE.meld with rules for stop(...), "
             "tell(...), expect(...) and never(...); repeatable");
    add_list(command, "--expect", run.expect, "BODY", "This must hold at the end, or the exit code is 3; repeatable");
    add_list(command, "--never", run.never, "BODY", "This may hold after no tick, or the exit code is 3; repeatable");
    command.add_option("--junit", run.junit, "Write how the run and each watch went, as JUnit XML")->type_name("FILE");
    command.add_flag("--sync", run.sync, "Wait after each recorded step, each digest and each file until it is on the disk");
    command.add_option("--timeout", run.timeout_seconds, "End compilation and run, each after so many seconds, with exit code 4")
        ->check(cli::seconds())
        ->type_name("SECONDS");
    command.add_flag("--stats", run.stats,
                     "Count what rules, predicates and catoms do, and the messages over links; print it with the summary");
    command.add_option("--profile", run.profile, "Write where the time went, and with --stats what it counts, for meldsim profile")
        ->type_name("FILE");
    command.add_flag("--json", run.json, "Print the summary as JSON");
    command.add_flag("--quiet", run.quiet, "Print no progress line and no summary");
}

}  // namespace meld::driver
