#include "runtime/driver/meldsim.h"

#include <CLI/CLI.hpp>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/ask/dap/serve.h"
#include "runtime/base/error.h"
#include "runtime/cli/command_line.h"
#include "runtime/driver/about/about_command.h"
#include "runtime/driver/grade/grade_command.h"
#include "runtime/driver/pictures/picture_commands.h"
#include "runtime/driver/questions/bisect.h"
#include "runtime/driver/questions/diff_command.h"
#include "runtime/driver/questions/profile_command.h"
#include "runtime/driver/questions/question_commands.h"
#include "runtime/driver/questions/world_command.h"
#include "runtime/driver/run/fork.h"
#include "runtime/driver/run/replay.h"
#include "runtime/driver/run/run.h"
#include "runtime/driver/session/debug.h"
#include "runtime/driver/session/view.h"
#include "runtime/driver/setup/option_groups.h"
#include "runtime/driver/study/sweep_command.h"

namespace meld::driver {

namespace {

// What a command line of meldsim says.
struct CommandLine {
    enum class Command {
        Run,
        Resume,
        Fork,
        Diff,
        Bisect,
        Replay,
        Debug,
        Serve,
        Inquire,
        Profile,
        World,
        Sweep,
        About,
        Grade
    } command = Command::Run;
    RunOptions run = {};
    ResumeOptions resume = {};
    ForkOptions fork = {};
    DiffOptions diff = {};
    RunOptions bisect = {};
    std::string bisect_scratch = {};
    ReplayOptions replay = {};
    RunOptions debug = {};
    std::string debug_scratch = {};
    bool debug_served = false;
    Asking query = {}, facts = {}, why = {}, why_not = {}, history = {}, messages = {}, depends = {}, shot = {}, movie = {}, exported = {},
           view = {};
    ProfileOptions profile = {};
    WorldOptions world = {};
    SweepOptions sweep = {};
    GradeOptions grade = {};
    AboutOptions about = {};
};

// ---- the commands

CLI::App* add_run(CLI::App& app, RunOptions& run) {
    CLI::App* r = app.add_subcommand("run",
                                     "Run a program until nothing is left to do, compiling it if needed.\nExample: meldsim run "
                                     "examples/meld/gradient.meld -n 2 --facts-out gradient.facts");
    add_program(*r, run);
    add_outputs(*r, run);
    r->add_option("--balance", run.balance,
                  "When to divide the catoms among the processes anew: auto, when processes lose more by waiting than that costs; "
                  "never; or in each so many ticks, as 100ticks")
        ->type_name("WHEN")
        ->capture_default_str();
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
    add_supervision(*s, resume.retries, resume.heartbeat);
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
    std::size_t depth = kWitnessDepth;
};

CLI::App* add_bisect(CLI::App& app, RunOptions& run, Bodies& bodies, std::string& scratch) {
    CLI::App* b = app.add_subcommand("bisect",
                                     "Find the first tick in which a body, in Meld, holds.\nExample: meldsim bisect "
                                     "examples/meld/gradient.meld --until 'dist(A, D), D > 20'");
    add_program(*b, run)->description("The program, as for meldsim run; or a recording; or a folder of checkpoints");
    CLI::Option* until = b->add_option("--until", bodies.until, "Find the first tick in which this body holds");
    CLI::Option* holding =
        b->add_option("--while", bodies.holding, "Find the first tick in which this body no longer holds at a catom at which it held");
    until->type_name("BODY")->excludes(holding);
    holding->type_name("BODY");
    b->add_option("--depth", bodies.depth, "Say why the body holds: follow its facts so many steps; 0: do not")
        ->type_name("INT")
        ->capture_default_str();
    b->add_flag("--json", run.json, "Print the answer as JSON");
    b->add_flag("--quiet", run.quiet, "Print no progress line");
    b->add_option("--module", run.module)->group("");
    b->add_option("--scratch", scratch)->group("");
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

CLI::App* add_debug(CLI::App& app, RunOptions& run, std::string& scratch, bool& served) {
    run.debug.emplace();
    CLI::App* d = app.add_subcommand("debug",
                                     "Walk through a run, forward and back, and see what holds: commands come from standard input, and "
                                     "help tells them.\nExample: meldsim debug examples/meld/gradient.meld");
    add_program(*d, run)->description("The program, as for meldsim run; or a recording; or a folder of checkpoints")->required(false);
    d->add_flag("--dap", served, "Serve an editor over standard input and output (Debug Adapter Protocol), which says what is run");
    d->callback([d, &served] {
        if (!served && d->count("PROGRAM") == 0) throw CLI::RequiredError("PROGRAM");
        if (served && d->parse_order().size() > 1)
            throw CLI::ValidationError("--dap", "it stands alone: the editor says what is run, and how");
    });
    d->add_option("--history", run.debug->history, "Memory for snapshots, of each process; 0: every way back is from the start")
        ->type_name("BYTES")
        ->capture_default_str();
    d->add_option("--commands", run.debug->commands, "Take the commands from this file")->type_name("FILE");
    d->add_flag("--json", run.json, "Print each answer as JSON, on a line");
    d->add_flag("--quiet", run.quiet, "Print no progress line");
    d->add_option("--module", run.module)->group("");
    d->add_option("--scratch", scratch)->group("");
    d->add_option("--folder", run.debug->folder)->group("");
    d->add_flag("--typed", run.debug->typed)->group("");
    d->add_flag("--shown", run.debug->shown)->group("");
    d->add_flag("--served", run.debug->served)->group("");
    return d;
}

CLI::App* add_profile(CLI::App& app, ProfileOptions& profile) {
    CLI::App* p = app.add_subcommand("profile",
                                     "Show the profile of a run: its hottest rules, what rules, predicates and catoms did, and where the "
                                     "time went.\nExample: meldsim profile run.profile --trace run.json");
    p->add_option("FILE", profile.file, "What meldsim run --profile has written")->required();
    p->add_option("--trace", profile.trace,
                  "Also write the ticks and stages of each process and thread as trace events, for Perfetto, Chrome or speedscope")
        ->type_name("FILE");
    p->add_flag("--json", profile.json, "Print the profile as JSON");
    return p;
}

CLI::App* add_world(CLI::App& app, WorldOptions& world) {
    CLI::App* w =
        app.add_subcommand("world",
                           "Check a world; print how many catoms it has, where they are, and what memory they take.\nExample: meldsim "
                           "world examples/meld/gradient.toml --shot gradient.png");
    CLI::Option* const file = w->add_option("FILE", world.file, "The world, a .toml file");
    CLI::Option* const import = w->add_option("--import", world.import, "Make the world of a configuration of VisibleSim, an .xml file")
                                    ->type_name("FILE")
                                    ->excludes(file);
    w->add_option("--lattice", world.lattice, "Of its modules: square (SmartBlocks), hex (Catoms2D), cubic (BlinkyBlocks), fcc (Catoms3D)")
        ->type_name("NAME")
        ->needs(import);
    w->add_option("-o,--output", world.output, "The world that is made; - for standard output")->type_name("FILE")->needs(import);
    w->add_option("--links", world.links,
                  "Write the links of a graph as CSV, as a world reads them with links = FILE; - for standard output")
        ->type_name("FILE")
        ->excludes(import);
    w->add_option("--nodes", world.nodes, "The same of its nodes, their places and columns, as nodes = FILE; - for standard output")
        ->type_name("FILE")
        ->excludes(import);
    add_list(*w, "--extension", world.extensions, "FILE", "As for meldsim run; repeatable");
    w->add_option("--shot", world.picture.file, "Take a picture of the catoms where they start, as a PNG file; - for standard output")
        ->type_name("FILE")
        ->group("Picture");
    add_start_view(*w, world.picture);
    return w;
}

// Returns the exit code if the program is to end here.
std::optional<int> read_command_line(int argc, const char* const* argv, CommandLine& line) {
    line.run.arguments.assign(argv, argv + argc);
    line.run.command = line.run.arguments;

    CLI::App app{"meldsim runs Meld programs on ensembles of catoms.\n\nExample: meldsim run examples/meld/gradient.meld", "meldsim"};
    app.require_subcommand(1);
    app.footer(
        "Exit codes: 0 success, 1 an error in the program, 2 usage or world, 3 nothing found, not as recorded, or not as watched for, 4 "
        "limit, memory or disk, 5 an unusable module, 6 an unusable checkpoint, recording, profile or table of facts, 70 a bug of "
        "meldsim, 130 interrupted, 143 terminated. Of diff: 1 if there is a difference. Of query and why: 1 if there is nothing; of "
        "why-not: 1 if the fact holds.");
    add_run(app, line.run);
    const CLI::App* resume = add_resume(app, line.resume);
    const CLI::App* fork = add_fork(app, line.fork);
    const CLI::App* diff = add_diff(app, line.diff);
    Bodies bodies;
    const CLI::App* bisect = add_bisect(app, line.bisect, bodies, line.bisect_scratch);
    const CLI::App* replay = add_replay(app, line.replay);
    const CLI::App* debug = add_debug(app, line.debug, line.debug_scratch, line.debug_served);
    add_query(app, line.query);
    add_facts(app, line.facts);
    add_why(app, line.why, "why");
    add_why(app, line.why_not, "why-not");
    add_history(app, line.history);
    add_messages(app, line.messages);
    add_depends(app, line.depends);
    add_shot(app, line.shot);
    add_view(app, line.view);
    add_movie(app, line.movie);
    add_export(app, line.exported);
    const CLI::App* profile = add_profile(app, line.profile);
    const CLI::App* world = add_world(app, line.world);
    const CLI::App* sweep = add_sweep(app, line.sweep);
    const CLI::App* grade = add_grade(app, line.grade);
    const CLI::App* about = add_about(app, line.about);
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
            line.bisect.question = {until ? Asks::Until : Asks::While, until ? bodies.until : bodies.holding, bodies.depth};
    }
    if (*replay) {
        line.command = CommandLine::Command::Replay;
        line.replay.run.arguments = line.run.arguments;
    }
    if (*debug) {
        line.command = line.debug_served ? CommandLine::Command::Serve : CommandLine::Command::Debug;
        line.debug.arguments = line.run.arguments;
    }
    for (Asking* const asking : {&line.shot, &line.movie, &line.exported})
        if (*asking->command) note_flags(*asking);
    for (Asking* const asking : {&line.query, &line.facts, &line.why, &line.why_not, &line.history, &line.messages, &line.depends,
                                 &line.shot, &line.movie, &line.exported, &line.view}) {
        if (!*asking->command) continue;
        line.command = CommandLine::Command::Inquire;
        line.debug = std::move(asking->run);
        line.debug_scratch = std::move(asking->scratch);
        line.debug.arguments = line.run.arguments;
    }
    if (*profile) line.command = CommandLine::Command::Profile;
    if (*world) line.command = CommandLine::Command::World;
    if (*sweep) line.command = CommandLine::Command::Sweep;
    if (*grade) line.command = CommandLine::Command::Grade;
    if (*about) line.command = CommandLine::Command::About;
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

}  // namespace

int run_meldsim(int argc, char** argv) {
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
            return bisect_command(std::move(line.bisect), std::move(line.bisect_scratch), run_options);
        case CommandLine::Command::Replay:
            return replay_command(line.replay);
        case CommandLine::Command::Debug:
        case CommandLine::Command::Inquire:
            return debug_command(std::move(line.debug), std::move(line.debug_scratch), run_options);
        case CommandLine::Command::Serve:
            return dap::serve();
        case CommandLine::Command::Profile:
            return profile_command(line.profile);
        case CommandLine::Command::World:
            return world_command(line.world);
        case CommandLine::Command::Sweep:
            return sweep_command(line.sweep);
        case CommandLine::Command::Grade:
            return grade_command(line.grade);
        case CommandLine::Command::About:
            return about_command(line.about, run_options);
    }
    return 0;
}

}  // namespace meld::driver
