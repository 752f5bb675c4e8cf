// meldsim: run Meld programs on ensembles of catoms.
#include <CLI/CLI.hpp>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "runtime/base/deep_stack.h"
#include "runtime/base/error.h"
#include "runtime/base/standard_streams.h"
#include "runtime/cli/command_line.h"
#include "runtime/driver/debug.h"
#include "runtime/driver/diff_command.h"
#include "runtime/driver/fork.h"
#include "runtime/driver/replay.h"
#include "runtime/driver/run.h"
#include "runtime/driver/world_command.h"

namespace {

using namespace meld::driver;
namespace cli = meld::cli;

// What a command line of meldsim says.
struct CommandLine {
    enum class Command { Run, Resume, Fork, Diff, Bisect, Replay, Debug, World } command = Command::Run;
    RunOptions run = {};
    ResumeOptions resume = {};
    ForkOptions fork = {};
    DiffOptions diff = {};
    RunOptions bisect = {};
    ReplayOptions replay = {};
    RunOptions debug = {};
    std::string debug_scratch = {};
    std::string world = {};
    std::vector<std::string> world_extensions = {};
};

// ---- groups of options that several commands have

template <class Ticks>
void add_ticks(CLI::App& command, Ticks& ticks, const std::string& text) {
    command.add_option("--ticks", ticks, text)->check(cli::whole_number(0, std::numeric_limits<std::int64_t>::max() - 1))->type_name("INT");
}

// Numbers that are optional are those of another run, if they are not given.
template <class Number>
void add_processes(CLI::App& command, Number& processes, Number& threads) {
    CLI::Option* const n = command.add_option("-n,--processes", processes, "Number of processes, started through mpirun");
    n->check(cli::whole_number(1, 100000))->type_name("INT");
    CLI::Option* const t = command.add_option("--threads", threads, "Worker threads in each process");
    t->check(cli::whole_number(1, 1024))->type_name("INT");
    if constexpr (std::is_same_v<Number, int>)
        for (CLI::Option* option : {n, t}) option->capture_default_str();
}

// Options that may be given several times, with one value each.
CLI::Option* add_list(CLI::App& command, const std::string& name, std::vector<std::string>& values, const char* type, const char* text) {
    return command.add_option(name, values, text)->type_name(type)->take_all()->allow_extra_args(false);
}

// What is run besides the program.
void add_inputs(CLI::App& command, RunOptions& run, const char* world) {
    command.add_option("--world", run.world, world)->type_name("FILE");
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

// The files that a run writes, and what it says.
void add_outputs(CLI::App& command, RunOptions& run) {
    command
        .add_option("--facts-out", run.facts_out,
                    "Write all facts at the end: as text, - for standard output; FOLDER/ for CSV tables; .h5 for HDF5 tables")
        ->type_name("FILE");
    command.add_option("--record", run.record, "Record positions, colours and the world's [record] predicates as VTKHDF")
        ->type_name("FILE");
    command.add_option("--digest", run.digest, "Write a digest of the state after every tick; - for standard output")->type_name("FILE");
    command
        .add_option("--checkpoint", run.checkpoint,
                    "Keep checkpoints in this folder, from which meldsim resume goes on: now and then, at Ctrl-C, and at the end")
        ->type_name("DIR");
    command.add_option("--checkpoint-every", run.checkpoint_every, "How often: a time such as 30s, or 1000ticks")
        ->type_name("INTERVAL")
        ->capture_default_str();
    command
        .add_option("--retries", run.retries, "With --checkpoint: how often to go on from it when a process is killed, crashes or hangs")
        ->check(cli::whole_number(0, 1000000))
        ->type_name("INT")
        ->capture_default_str();
    command
        .add_option("--heartbeat", run.heartbeat,
                    "With --checkpoint: a run without a sign of life for so long hangs; off: it may take any time")
        ->type_name("TIME")
        ->capture_default_str();
    command.add_flag("--sync", run.sync, "Wait after each recorded step, each digest and each file until it is on the disk");
    command.add_option("--timeout", run.timeout_seconds, "End compilation and run, each after so many seconds, with exit code 4")
        ->check(CLI::Range(0.001, 1e9).description(""))
        ->type_name("SECONDS");
    command.add_flag("--json", run.json, "Print the summary as JSON");
    command.add_flag("--quiet", run.quiet, "Print no progress line and no summary");
}

// ---- the commands
CLI::App* add_run(CLI::App& app, RunOptions& run) {
    CLI::App* r = app.add_subcommand("run",
                                     "Run a program until nothing is left to do, compiling it if needed.\nExample: meldsim run "
                                     "examples/meld/gradient.meld -n 2 --facts-out gradient.facts");
    add_program(*r, run);
    add_outputs(*r, run);
    // The command by which meldsim fork starts its processes.
    r->add_option("--forked-from", run.fork)->group("");
    r->add_option("--module", run.module)->group("");
    return r;
}

CLI::App* add_resume(CLI::App& app, ResumeOptions& resume) {
    CLI::App* s =
        app.add_subcommand("resume",
                           "Go on with a run from its newest checkpoint, in the folder where it was started, with the options and "
                           "the files that it had.\nExample: meldsim resume checkpoints -n 4");
    s->add_option("DIR", resume.folder, "The folder that meldsim run --checkpoint has written to")->required();
    add_processes(*s, resume.processes, resume.threads);
    add_ticks(*s, resume.ticks, "Stop after this many ticks, counted from the start of the run");
    s->add_flag("--json", resume.json, "Print the summary as JSON");
    s->add_flag("--quiet", resume.quiet, "Print no progress line and no summary");
    s->add_option("--module", resume.module)->group("");
    return s;
}

CLI::App* add_fork(CLI::App& app, ForkOptions& fork) {
    CLI::App* f = app.add_subcommand("fork",
                                     "Branch off from a run at its newest checkpoint: with a program that has changed, other constants, "
                                     "another seed or other events.\nExample: meldsim fork checkpoints --program better.meld");
    f->add_option("DIR", fork.folder, "The folder that meldsim run --checkpoint has written to")->required();
    f->add_option("--program", fork.run.program, "Another program; otherwise that of the run, as its file is now")->type_name("FILE");
    add_inputs(*f, fork.run, "Another world, whose catoms are the same; otherwise that of the run, as its file is now");
    add_ticks(*f, fork.run.ticks, "Stop after this many ticks, counted from the start of the run");
    add_processes(*f, fork.run.processes, fork.run.threads);
    add_outputs(*f, fork.run);
    return f;
}

CLI::App* add_diff(CLI::App& app, DiffOptions& diff) {
    CLI::App* d = app.add_subcommand("diff",
                                     "Compare two recordings, two folders of checkpoints, two digest files or two sets of facts: print the "
                                     "first tick, catom and fact in which they differ.\nExample: meldsim diff one.digest two.digest");
    d->add_option("A", diff.a, "What --record, --checkpoint, --digest or --facts-out has written")->required();
    d->add_option("B", diff.b, "Another of the same kind")->required();
    d->add_flag("--json", diff.json, "Print the differences as JSON; of facts all of them");
    return d;
}

// The bodies of both options; one is given.
struct Bodies {
    std::string until = {}, holding = {};
};

CLI::App* add_bisect(CLI::App& app, RunOptions& run, Bodies& bodies) {
    CLI::App* b = app.add_subcommand("bisect",
                                     "Find the first tick in which a body, in Meld, holds at some catom.\nExample: meldsim bisect "
                                     "examples/meld/gradient.meld --until 'dist(A, D), D > 20'");
    add_program(*b, run);
    CLI::Option* until = b->add_option("--until", bodies.until, "Find the first tick in which this body holds at some catom");
    CLI::Option* holding =
        b->add_option("--while", bodies.holding, "Find the first tick in which this body no longer holds at a catom at which it held");
    until->type_name("BODY")->excludes(holding);
    holding->type_name("BODY");
    b->add_flag("--json", run.json, "Print the answer as JSON");
    b->add_flag("--quiet", run.quiet, "Print no progress line");
    b->add_option("--module", run.module)->group("");
    return b;
}

CLI::App* add_replay(CLI::App& app, ReplayOptions& replay) {
    CLI::App* r = app.add_subcommand("replay",
                                     "Make the run of a recording again, from what the recording carries, and compare it in every recorded "
                                     "step.\nExample: meldsim replay run.vtkhdf --to 40");
    r->add_option("RECORDING", replay.recording, "What meldsim run --record has written")->required();
    r->add_option("--to", replay.to, "Stop after this tick; otherwise after the last one of the recording")
        ->check(cli::whole_number(0, std::numeric_limits<std::int64_t>::max() - 1))
        ->type_name("INT");
    add_processes(*r, replay.run.processes, replay.run.threads);
    add_list(*r, "--link", replay.link, "FILE", "A C or C++ file with extern functions of the run, if it is not where it was; repeatable");
    add_list(*r, "--extension", replay.extensions, "FILE", "An extension of the run, if it is not where it was; repeatable");
    r->add_option("--facts-out", replay.run.facts_out, "Write all facts after the last tick, as meldsim run does")->type_name("FILE");
    r->add_option("--digest", replay.run.digest, "Write a digest of the state after every tick; - for standard output")->type_name("FILE");
    r->add_flag("--json", replay.run.json, "Print the outcome as JSON");
    r->add_flag("--quiet", replay.run.quiet, "Print no progress line, and nothing if the run is the same");
    r->add_option("--module", replay.run.module)->group("");
    r->add_option("--scratch", replay.scratch)->group("");
    return r;
}

CLI::App* add_debug(CLI::App& app, RunOptions& run, std::string& scratch) {
    run.debug.emplace();
    CLI::App* d = app.add_subcommand("debug",
                                     "Walk through a run, forward and back, and see what holds: commands come from standard input, and "
                                     "help tells them.\nExample: meldsim debug examples/meld/gradient.meld");
    add_program(*d, run)->description("The program, as for meldsim run; or a recording; or a folder of checkpoints");
    d->add_option("--history", run.debug->history, "Memory for snapshots, of each process; 0: every way back is from the start")
        ->type_name("BYTES")
        ->capture_default_str();
    d->add_option("--commands", run.debug->commands, "Take the commands from this file")->type_name("FILE");
    d->add_flag("--json", run.json, "Print each answer as JSON, on a line");
    d->add_flag("--quiet", run.quiet, "Print no progress line");
    d->add_option("--module", run.module)->group("");
    d->add_option("--scratch", scratch)->group("");
    d->add_flag("--typed", run.debug->typed)->group("");
    d->add_flag("--shown", run.debug->shown)->group("");
    return d;
}

CLI::App* add_world(CLI::App& app, std::string& path, std::vector<std::string>& extensions) {
    CLI::App* w = app.add_subcommand(
        "world", "Check a world; print how many catoms it has and where they are.\nExample: meldsim world examples/meld/gradient.toml");
    w->add_option("FILE", path, "The world, a .toml file")->required();
    w->add_option("--extension", extensions, "As for meldsim run; repeatable")->type_name("FILE")->take_all()->allow_extra_args(false);
    return w;
}

// Returns the exit code if the program is to end here.
std::optional<int> read_command_line(int argc, const char* const* argv, CommandLine& line) {
    line.run.arguments.assign(argv, argv + argc);
    line.run.command = line.run.arguments;

    CLI::App app{"meldsim runs Meld programs on ensembles of catoms.\n\nExample: meldsim run examples/meld/gradient.meld", "meldsim"};
    app.require_subcommand(1);
    app.footer(
        "Exit codes: 0 success, 1 an error in the program, 2 usage or world, 3 nothing found, or not as recorded, 4 limit, memory or disk, "
        "5 an unusable module, 6 an unusable checkpoint, recording or table of facts, 70 a bug of meldsim, 130 interrupted, 143 "
        "terminated. Of diff: 1 if there is a difference.");
    add_run(app, line.run);
    const CLI::App* resume = add_resume(app, line.resume);
    const CLI::App* fork = add_fork(app, line.fork);
    const CLI::App* diff = add_diff(app, line.diff);
    Bodies bodies;
    const CLI::App* bisect = add_bisect(app, line.bisect, bodies);
    const CLI::App* replay = add_replay(app, line.replay);
    const CLI::App* debug = add_debug(app, line.debug, line.debug_scratch);
    const CLI::App* world = add_world(app, line.world, line.world_extensions);
    cli::add_common(app);
    const cli::Elsewhere elsewhere = {{"check", "meldc"}, {"compile", "meldc"}, {"explain", "meldc"}, {"fmt", "meldc"}, {"lsp", "meldc"}};
    if (const std::optional<int> code = cli::parse(app, argc, argv, {}, elsewhere)) return code;
    if (*resume) line.command = CommandLine::Command::Resume;
    if (*fork) line.command = CommandLine::Command::Fork;
    if (*diff) line.command = CommandLine::Command::Diff;
    if (*bisect) {
        line.command = CommandLine::Command::Bisect;
        line.bisect.arguments = line.run.arguments;
        using Asks = Question::Asks;
        const bool until = bisect->count("--until") > 0;
        if (until || bisect->count("--while") > 0)
            line.bisect.question = {until ? Asks::Until : Asks::While, until ? bodies.until : bodies.holding};
    }
    if (*replay) {
        line.command = CommandLine::Command::Replay;
        line.replay.run.arguments = line.run.arguments;
    }
    if (*debug) {
        line.command = CommandLine::Command::Debug;
        line.debug.arguments = line.run.arguments;
    }
    if (*world) line.command = CommandLine::Command::World;
    // The processes are told where the module is; nobody has typed that.
    std::vector<std::string>& typed = line.run.command;
    if (!line.run.module.empty() && typed.size() > 2 && typed[typed.size() - 2] == "--module") typed.resize(typed.size() - 2);
    return std::nullopt;
}

// The options of a run by its command, as a checkpoint has it.
std::optional<RunOptions> run_options(const std::vector<std::string>& command) {
    std::vector<const char*> words;
    for (const std::string& word : command) words.push_back(word.c_str());
    CommandLine line;
    // Words that ask for something else, such as help, were never those of a run.
    if (words.size() < 3 || command[1] != "run") return std::nullopt;
    if (read_command_line(static_cast<int>(words.size()), words.data(), line)) return std::nullopt;
    return line.run;
}

int run_program(int argc, char** argv) {
    CommandLine line;
    if (const std::optional<int> code = read_command_line(argc, argv, line)) return *code;
    switch (line.command) {
        case CommandLine::Command::Run:
            return run_command(std::move(line.run));
        case CommandLine::Command::Resume:
            return resume_command(line.resume, run_options);
        case CommandLine::Command::Fork:
            return fork_command(std::move(line.fork), run_options);
        case CommandLine::Command::Diff:
            return diff_command(line.diff, run_options);
        case CommandLine::Command::Bisect:
            return bisect_command(std::move(line.bisect));
        case CommandLine::Command::Replay:
            return replay_command(line.replay);
        case CommandLine::Command::Debug:
            return debug_command(std::move(line.debug), std::move(line.debug_scratch), run_options);
        case CommandLine::Command::World:
            return world_command(line.world, line.world_extensions);
    }
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    meld::prepare_standard_streams();
    meld::end_when_memory_runs_out("meldsim");
    return meld::end_standard_output("meldsim", meld::ending_when_memory_runs_out([&] { return run_program(argc, argv); }));
}
