#include "runtime/driver/asking.h"

#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <vector>

#include "runtime/debug/depends.h"
#include "runtime/driver/option_groups.h"
#include "runtime/inspect/why.h"

namespace meld::driver {

namespace {

// What is run, for all of them.
void add_run(CLI::App& command, Asking& asking) {
    asking.command = &command;
    RunOptions& run = asking.run;
    add_inputs(command, run, "The world, a .toml file; the default is the .toml next to the program, or else a cube of 1,000 catoms");
    add_processes(command, run.processes, run.threads);
    command.add_flag("--json", run.json, "Print the answer as JSON");
    command.add_flag("--quiet", run.quiet, "Print no progress line");
    command.add_option("--module", run.module)->group("");
    command.add_option("--scratch", asking.scratch)->group("");
}

// The options of those that print an answer about one tick.
void add_inquiry(CLI::App& command, Asking& asking) {
    RunOptions& run = asking.run;
    Inquiry& inquiry = *run.debug->inquiry;
    command
        .add_option("--tick", inquiry.tick,
                    "The tick after which it is asked; 0: before the first. Otherwise where the run ends, or where the checkpoint is")
        ->check(cli::whole_number(0, std::numeric_limits<std::int64_t>::max() - 1))
        ->type_name("INT");
    add_run(command, asking);
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

void add_view(CLI::App& command, ShotOptions& shot) {
    CLI::App* const s = &command;
    const auto add = [&](const char* name, auto& value, const char* type, const char* text) {
        return s->add_option(name, value, text)->type_name(type)->group("Picture");
    };
    add("--form", shot.form, "FORM", "Draw sphere, cube, disc or hexagon; otherwise what fits the lattice");
    add("--catom-size", shot.catom_size, "FACTOR", "Draw catoms so much smaller; otherwise 0.5 where lines are among them in space, or 1");
    add("--size", shot.size, "WxH", "Pixels of the whole picture")->capture_default_str();
    add("--azimuth", shot.azimuth, "DEGREES", "Where the camera stands, from the x axis towards the y axis");
    add("--elevation", shot.elevation, "DEGREES", "How high the camera stands");
    add("--angle", shot.angle, "DEGREES", "How much the camera sees; 0: parallel, without perspective");
    add("--zoom", shot.zoom, "FACTOR", "Show the middle larger")->capture_default_str();
    s->add_flag("--ground", shot.ground, "Show shadows on a floor")->group("Picture");
    s->add_flag("--scale", shot.scale, "Draw a scale")->group("Picture");
    s->add_flag("--bare", shot.bare, "Write neither ticks nor a legend")->group("Picture");
    add("--title", shot.title, "TEXT", "Write this above");
    add("--background", shot.background, "COLOUR", "As #RRGGBB, or white, black, grey or transparent")->capture_default_str();
    add("--samples", shot.samples, "INT", "Rays through a pixel, along each side")->capture_default_str()->check(cli::whole_number(1, 16));
}

void add_shot(CLI::App& app, Asking& asking) {
    RunOptions& run = asking.run;
    run.debug = {.history = "0", .inquiry = Inquiry{.command = "shot", .words = {}}, .shot = ShotOptions{}};
    ShotOptions& shot = *run.debug->shot;
    CLI::App* s = app.add_subcommand(
        "shot",
        "Take a picture of a run, as a PNG file. A BODY is in Meld, and about its first variable that is a catom.\nExample: "
        "meldsim shot examples/meld/gradient.meld -o gradient.png --colour 'dist(A, D)'");
    s->add_option("TARGET", run.program, "A program, which is run; or a recording; or a folder of checkpoints")->required();
    const auto add = [&](const char* name, auto& value, const char* type, const char* text) {
        return s->add_option(name, value, text)->type_name(type)->group("Picture");
    };
    add("-o,--output", shot.file, "FILE", "The picture; - for standard output")->required();
    add("--tick", shot.ticks, "T[,T...]", "Show the run after these ticks, side by side, as in 0,20,end; otherwise where it ends")
        ->delimiter(',');
    add("--colour,--color", shot.colour, "BODY",
        "Colour catoms by the last variable, as in 'dist(A, D)'; with one variable, those for which it holds");
    add("--map", shot.map, "NAME", "The colours of numbers: viridis, cividis, magma, coolwarm or grey")->capture_default_str();
    add("--range", shot.range, "LOW:HIGH", "The numbers at the ends of the colours; otherwise the least and the greatest");
    add("--only", shot.only, "BODY", "Show only catoms for which it holds");
    add("--hide", shot.hide, "BODY", "Do not show catoms for which it holds");
    add("--links", shot.links, "BODY", "Draw a line from a catom to the next variable that is a catom, or along a vec3");
    add("--arrows", shot.arrows, "BODY", "The same with an arrow");
    add("--labels", shot.labels, "BODY", "Write the value of the last variable at the catom");
    add("--columns", shot.columns, "INT", "How many frames of several stand side by side; otherwise as they fit")
        ->check(cli::whole_number(1, 1000));
    add_view(*s, shot);
    add_run(*s, asking);
}

void note_flags(Asking& asking) {
    std::vector<std::string>& flags = asking.run.debug->inquiry->flags;
    for (const CLI::Option* option : asking.command->get_options())
        if (option->get_group() == "Picture" && option->count() > 0)
            for (const std::string& value : option->results()) {
                flags.push_back(option->get_name());
                if (option->get_expected_max() > 0) flags.push_back(value);
            }
}

}  // namespace meld::driver
