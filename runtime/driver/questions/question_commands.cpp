#include "runtime/driver/questions/question_commands.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstdint>
#include <limits>
#include <vector>

#include "runtime/ask/debug/depends.h"
#include "runtime/ask/why/why.h"
#include "runtime/driver/setup/option_groups.h"

namespace meld::driver {

// The options that all of them share: in which world the target runs, on how many processes, and how the answer is printed.
void add_target_options(CLI::App& command, Asking& asking) {
    asking.command = &command;
    RunOptions& run = asking.run;
    add_inputs(command, run, "The world, a .toml file; the default is the .toml next to the program, or else a cube of 1,000 catoms");
    add_processes(command, run.processes, run.threads);
    command.add_flag("--json", run.json, "Print the answer as JSON");
    command.add_flag("--quiet", run.quiet, "Print no progress line");
    command.add_option("--module", run.module)->group("");
    command.add_option("--scratch", asking.scratch)->group("");
}

namespace {

// The options of those that print an answer about one tick.
void add_inquiry(CLI::App& command, Asking& asking) {
    RunOptions& run = asking.run;
    Inquiry& inquiry = *run.debug->inquiry;
    command
        .add_option("--tick", inquiry.tick,
                    "The tick after which it is asked; 0: before the first. Otherwise where the run ends, or where the checkpoint is")
        ->check(cli::whole_number(0, std::numeric_limits<std::int64_t>::max() - 1))
        ->type_name("INT");
    add_target_options(command, asking);
    const bool explains = inquiry.command == "why" || inquiry.command == "why-not" || inquiry.command == "history";
    if (!explains)
        command.add_option("--limit", inquiry.limit, "Print no more than so many; all are counted")
            ->check(cli::whole_number(0, std::numeric_limits<std::int64_t>::max() - 1))
            ->type_name("INT");
    if (inquiry.command == "query" || inquiry.command == "messages")
        command.add_flag("--csv", inquiry.csv, "Print a table of comma-separated values")->excludes("--json");
}

}  // namespace

void add_query(CLI::App& app, Asking& asking) {
    RunOptions& run = asking.run;
    run.debug = {.history = "0", .inquiry = Inquiry{.command = "query", .words = {}}};
    CLI::App* q =
        app.add_subcommand("query",
                           "Ask a run: print all ways to satisfy a body, in Meld, as a table. Exit code 1 if there are none.\nExample: "
                           "meldsim query examples/meld/gradient.meld 'dist(A, D), D > 20'");
    q->add_option("TARGET", run.program, "A program, which is run; or a recording; or a folder of checkpoints")->required();
    q->add_option("BODY", run.debug->inquiry->words, "What stands behind :- in a rule; it may join any catoms")->required()->expected(1);
    add_inquiry(*q, asking);
}

void add_facts(CLI::App& app, Asking& asking) {
    RunOptions& run = asking.run;
    run.debug = {.history = "0", .inquiry = Inquiry{.command = "facts", .words = {}}};
    CLI::App* f =
        app.add_subcommand("facts",
                           "Print what holds in a run: everything, what holds at a catom, or the facts of one predicate.\nExample: "
                           "meldsim facts examples/meld/gradient.meld @42");
    f->add_option("TARGET", run.program, "A program, which is run; or a recording; or a folder of checkpoints")->required();
    f->add_option("WHICH", run.debug->inquiry->words, "A catom, as @42; the name of a predicate; or both");
    add_inquiry(*f, asking);
}

void add_why(CLI::App& app, Asking& asking, const std::string& name) {
    RunOptions& run = asking.run;
    const bool holds = name == "why";
    run.debug = {.inquiry = Inquiry{.command = name, .words = {}}};
    std::vector<std::string>& flags = run.debug->inquiry->flags;
    CLI::App* w = app.add_subcommand(
        name, holds ? "Say why a fact holds: the rule and the facts that it rests on, down to what was given and sensed. Exit code 1 if it "
                      "does not hold.\nExample: meldsim why examples/meld/gradient.meld 'dist(@42, _)'"
                    : "Say why a fact does not hold: for each rule that could give it, the part of its body that fails. Exit code 1 if it "
                      "holds.\nExample: meldsim why-not examples/meld/gradient.meld 'dist(@42, 0)'");
    w->add_option("TARGET", run.program, "A program, which is run; or a recording; or a folder of checkpoints")->required();
    w->add_option("FACT", run.debug->inquiry->words, "A fact, in Meld; _ where anything will do")->required()->expected(1);
    w->add_option_function<std::uint64_t>(
         "--depth", [&flags](std::uint64_t depth) { flags.insert(flags.end(), {"--depth", std::to_string(depth)}); },
         fmt::format("Follow facts so many steps, otherwise {}; 0: to the end", holds ? inspect::kWhyDepth : inspect::kWhyNotDepth))
        ->type_name("INT");
    if (holds)
        w->add_flag_callback("--all", [&flags] { flags.emplace_back("--all"); }, "All facts that match, and all ways in which each holds");
    add_inquiry(*w, asking);
    w->add_flag("--dot", run.debug->inquiry->dot, "Print the answer for Graphviz")->excludes("--json");
}

void add_history(CLI::App& app, Asking& asking) {
    RunOptions& run = asking.run;
    run.debug = {.inquiry = Inquiry{.command = "history", .words = {}}};
    CLI::App* h = app.add_subcommand("history",
                                     "Print the ticks in which facts came and went.\nExample: meldsim history examples/meld/gradient.meld "
                                     "'dist(@42, _)'");
    h->add_option("TARGET", run.program, "A program, which is run; or a recording; or a folder of checkpoints")->required();
    h->add_option("FACT", run.debug->inquiry->words, "A fact, in Meld; _ where anything will do")->required()->expected(1);
    add_inquiry(*h, asking);
}

void add_messages(CLI::App& app, Asking& asking) {
    RunOptions& run = asking.run;
    run.debug = {.inquiry = Inquiry{.command = "messages", .words = {}}};
    CLI::App* m =
        app.add_subcommand("messages",
                           "Print what crosses the links in a tick: changed facts that neighbours read, and linear facts that are "
                           "sent.\nExample: meldsim messages examples/meld/gradient.meld @4 --tick 2");
    m->add_option("TARGET", run.program, "A program, which is run; or a recording; or a folder of checkpoints")->required();
    m->add_option("CATOM", run.debug->inquiry->words, "A catom, as @4, whose links alone are meant")->expected(0, 1);
    add_inquiry(*m, asking);
    m->add_flag("--dot", run.debug->inquiry->dot, "Print the answer for Graphviz")->excludes("--json")->excludes("--csv");
}

void add_depends(CLI::App& app, Asking& asking) {
    RunOptions& run = asking.run;
    run.debug = {.inquiry = Inquiry{.command = "depends", .words = {}}};
    std::vector<std::string>& flags = run.debug->inquiry->flags;
    CLI::App* d = app.add_subcommand("depends",
                                     "Print what would come and go if a given or linear fact were taken: the run goes on without it, and "
                                     "with it.\nExample: meldsim depends examples/meld/gradient.meld 'source(@0)' --limit 5");
    d->add_option("TARGET", run.program, "A program, which is run; or a folder of checkpoints")->required();
    d->add_option("FACT", run.debug->inquiry->words, "A fact, in Meld, that is given or linear")->required()->expected(1);
    d->add_option_function<std::int64_t>(
         "--ticks", [&flags](std::int64_t ticks) { flags.insert(flags.end(), {"--ticks", std::to_string(ticks)}); },
         fmt::format("Go on for so many ticks at most, otherwise {}", debug::kDependsTicks))
        ->check(cli::whole_number(1, std::numeric_limits<std::int64_t>::max() - 1))
        ->type_name("INT");
    add_inquiry(*d, asking);
}

}  // namespace meld::driver
