// meldc: check, compile, format and explain Meld programs.
#include <unistd.h>

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <optional>

#include "compiler/diagnostics/explain.h"
#include "compiler/driver/check_command.h"
#include "compiler/driver/compile.h"
#include "compiler/driver/format_command.h"
#include "runtime/base/did_you_mean.h"
#include "runtime/base/files/output_file.h"
#include "runtime/base/files/output_paths.h"
#include "runtime/base/files/standard_streams.h"
#include "runtime/base/process/deep_stack.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/cli/command_line.h"
#include "runtime/module/abi/module_note.h"

namespace {

using namespace meld;
using namespace meld::driver;

struct Options {
    std::string file;
    std::string output;
    std::string emit;
    std::string code;
    double timeout_seconds = 0;      // 0: none.
    std::vector<std::string> files;  // To check.
    bool json = false;
    bool all = false;
    bool fix = false;
    bool quiet = false;
    bool explain_rules = false;
    bool graph = false, no_graph = false;
    CompileOptions compile;
    FormatOptions format;
};

HowMany how_many(const Options& options) { return options.all ? HowMany::All : HowMany::MostSevere; }

// Messages go to standard error as text, or to standard output as JSON.
void show(const Compilation& c, const Options& options) {
    if (options.json)
        std::cout << diagnostics::render_json(c.files, c.report.sorted()) << "\n";
    else
        show_messages(c.files, c.report.sorted(), options.file, how_many(options));
}

Result<void> copy_module(const std::string& module, const std::string& path) {
    const Result<std::string> bytes = read_module_file(module);
    if (!bytes) return tl::unexpected(bytes.error());
    return write_file(path, *bytes);
}

// The files to read must differ from the file to write.
Result<void> check_paths(const Options& options) {
    std::vector<NamedPath> paths = {{"the program", options.file}, {"-o", options.output, NamedPath::Written}};
    for (const std::string& file : options.compile.link) paths.push_back({"--link", file});
    for (const std::string& file : options.compile.programs) paths.push_back({"--with", file});
    return check_distinct(paths);
}

// Without -O, the environment may say at which level modules are compiled: many short runs, such as tests, are done sooner with level 0.
Result<void> take_level_of_environment(CompileOptions& options) {
    const char* const said = std::getenv("CLAYMELD_OPTIMIZATION");
    if (options.optimisation || said == nullptr || *said == '\0') return {};
    if (said[1] != '\0' || *said < '0' || *said > '3')
        return fail(fmt::format("the environment variable CLAYMELD_OPTIMIZATION is a whole number from 0 to 3, not '{}'", said),
                    "Correct it, or unset it: then the length of the module decides");
    options.optimisation = *said - '0';
    return {};
}

int run_compile(Options& options) {
    if (const auto distinct = check_paths(options); !distinct) return fail_with(distinct.error());
    if (!options.emit.empty()) {
        const auto stage = stage_named(options.emit);
        if (!stage) return fail_with({"there is no stage '" + options.emit + "'", "Stages are tokens, ast, program, plan, cpp and module"});
        options.compile.last = *stage;
    }
    const auto known = [](const std::string& name, plan::Passes which) {
        const std::vector<std::string_view> passes = plan::passes(which);
        return name.empty() || std::find(passes.begin(), passes.end(), name) != passes.end();
    };
    for (const std::string& name : options.compile.plan.without)
        if (!known(name, plan::Passes::Optional))
            return fail_with(
                {"there is no pass '" + name + "' that can be left out", did_you_mean(name, plan::passes(plan::Passes::Optional))});
    const std::string& after = options.compile.plan.after;
    if (!known(after, plan::Passes::All))
        return fail_with({"there is no pass '" + after + "'", did_you_mean(after, plan::passes(plan::Passes::All))});
    if (!after.empty() && options.compile.last != Stage::Plan)
        return fail_with({"--after prints the plan after a pass", "Add --emit=plan"});
    if (options.explain_rules) options.compile.last = Stage::Explain;
    if (const auto taken = take_level_of_environment(options.compile); !taken) return fail_with(taken.error());
    options.compile.progress = !options.quiet;
    Compilation c;
    if (const auto done = compile(options.file, options.compile, c); !done) return fail_with(done.error());
    show(c, options);
    if (c.report.has_errors()) return static_cast<int>(ExitCode::ProgramWrong);
    if (options.compile.last != Stage::Module) {
        // The emitted C++ has escapes in its string literals already.
        std::cout << (options.compile.last == Stage::Cpp ? c.result : visible(c.result));
        return 0;
    }
    if (options.output.empty()) {
        std::cout << c.result << "\n";
        return 0;
    }
    if (const auto copied = copy_module(c.result, options.output); !copied) return fail_with(copied.error());
    return 0;
}

int run_explain(const Options& options) {
    const std::vector<diagnostics::KindInfo> kinds = diagnostics::all_kinds();
    std::vector<std::string> codes;
    for (std::size_t i = 0; i < kinds.size(); ++i) {
        codes.emplace_back(kinds[i].code);
        if (options.code != kinds[i].code && options.code != kinds[i].name) continue;
        std::cout << diagnostics::explanation(static_cast<diagnostics::Kind>(i));
        return 0;
    }
    const std::string near = diagnostics::nearest_name(options.code, codes);
    return fail_with({"there is no message '" + options.code + "'", near.empty() ? "Codes look like E0301" : "Did you mean " + near + "?"});
}

// The words that completion offers for options and arguments.
cli::Choices choices() {
    const auto words = [](const std::vector<std::string_view>& names) { return std::vector<std::string>(names.begin(), names.end()); };
    cli::Choices all;
    all["--emit"] = {"tokens", "ast", "program", "plan", "cpp", "module"};
    all["--after"] = words(plan::passes(plan::Passes::All));
    all["--without"] = words(plan::passes(plan::Passes::Optional));
    for (const diagnostics::KindInfo& kind : diagnostics::all_kinds()) all["explain"].emplace_back(kind.code);
    return all;
}

// The language server is a separate program: it loads LLVM, which meldc itself does not need. Returns only if it cannot be started.
int run_language_server() {
    std::error_code error;
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
    const std::string server = (program.parent_path() / "meldc-lsp").string();
    char* const arguments[] = {const_cast<char*>(server.c_str()), nullptr};
    ::execv(server.c_str(), arguments);
    return fail_with({"cannot start " + server + ": " + std::strerror(errno), "Keep meldc-lsp beside meldc"});
}

// What `check` and `compile` have in common.
void add_common_options(CLI::App& command, Options& options) {
    command.add_flag("--json", options.json, "Print messages as JSON on standard output");
    command.add_flag("--all", options.all, "Print all messages, not only the 50 most severe of a program");
    command.add_option("-I,--library", options.compile.library_paths, "Search this folder for include, use and import; repeatable")
        ->type_name("DIR")
        ->take_all()
        ->allow_extra_args(false);
    CLI::Option* const graph =
        command.add_flag("--graph", options.graph, "For worlds that are graphs, where facts also reach nodes that no link leads to");
    command
        .add_flag("--no-graph", options.no_graph,
                  "For worlds that are no graphs; by default the program decides, as it does without a world")
        ->excludes(graph);
    command.add_flag("--acyclic", options.compile.acyclic,
                     "The links of the graph lead in no circle: no warning of values that grow from link to link");
    command.add_option("--lattice", options.compile.lattice, "The lattice of the world, for a warning about the numbers of ports")
        ->type_name("NAME");
    command.add_option("--ports", options.compile.ports, "Whose numbers its ports have, as the world says: no warning about them")
        ->type_name("ROBOT");
    command.add_option("--with", options.compile.programs, "Another program that some catoms of the same ensemble run; repeatable")
        ->type_name("FILE")
        ->take_all()
        ->allow_extra_args(false);
    command.add_option("--timeout", options.timeout_seconds, "End after so many seconds, with exit code 4")
        ->check(cli::seconds())
        ->type_name("SECONDS");
}

void add_compile_options(CLI::App& command, Options& options) {
    command.add_option("FILE", options.file, "The program, a .meld file")->required();
    add_common_options(command, options);
    command
        .add_option("-o,--output", options.output,
                    "Write the module to this file; by default it stays in the cache, and its path is printed")
        ->type_name("FILE");
    command.add_option("--emit", options.emit, "Print a stage instead: tokens, ast, program, plan, cpp, module")->type_name("STAGE");
    command.add_flag("--explain-rules", options.explain_rules,
                     "Print where each rule runs, in which order it reads and why, what it sends, and how each predicate is stored");
    command
        .add_option("-O", options.compile.optimisation,
                    "Optimization of the module, 0 to 3; the default is CLAYMELD_OPTIMIZATION, or 2 for short modules and 1 for long ones")
        ->check(cli::whole_number(0, 3));
    command.add_option("--after", options.compile.plan.after, "With --emit=plan: print the program or plan after this pass of the planner")
        ->type_name("PASS");
    command.add_option("--without", options.compile.plan.without, "Skip an optimizing pass of the planner; results do not change")
        ->type_name("PASS");
    command.add_option("--link", options.compile.link, "A C or C++ file that defines extern functions; repeatable")
        ->type_name("FILE")
        ->take_all()
        ->allow_extra_args(false);
    command.add_flag("--counters", options.compile.plan.counts,
                     "Count what each rule does, 10 to 20 % slower: a module for meldsim run --stats and --profile");
    command.add_flag("--links", options.compile.plan.links, "Find neighbours in a table: for networks that are not ideal");
    command.add_flag("--places", options.compile.plan.places,
                     "Say at any time which rule runs, some 3 % slower: a module for meldsim run --profile");
    command.add_flag(
        "--checked", options.compile.plan.checked,
        "Let the module check what its code takes for granted, and end the run where that does not hold: to find our own bugs");
    command.add_flag("--quiet", options.quiet, "Print no progress line");
    command.add_option("--cache", options.compile.cache_dir, "Folder of compiled modules")->type_name("DIR");
}

int run_program(int argc, char** argv) {
    Options options;
    CLI::App app{
        "meldc checks, compiles, formats and explains Meld programs.\n\nExample: meldc compile examples/meld/gradient.meld --explain-rules",
        "meldc"};
    app.require_subcommand(1);
    app.footer("Exit codes: 0 success, 1 an error in the program, 2 usage or files, 4 limit, memory or disk, 70 a bug of meldc.");

    CLI::App* check = app.add_subcommand("check", "Report every mistake in programs.\nExample: meldc check examples/meld/gradient.meld");
    CLI::App* compile = app.add_subcommand(
        "compile", "Compile a program to a module, or print a stage of it.\nExample: meldc compile examples/meld/gradient.meld --emit=cpp");
    check->add_option("FILE", options.files, "The programs, .meld files")->required();
    add_common_options(*check, options);
    check->add_flag("--fix", options.fix, "Apply the safe fixes to the files first, then print the messages that remain");
    add_compile_options(*compile, options);
    CLI::App* explain =
        app.add_subcommand("explain", "Explain a message: what it means, a wrong program and its cure.\nExample: meldc explain E0501");
    explain->add_option("CODE", options.code, "A code such as E0501")->required();

    CLI::App* format =
        app.add_subcommand("fmt", "Format programs; comments and meaning stay the same.\nExample: meldc fmt examples/meld/gradient.meld");
    format
        ->add_option("FILE", options.format.files, "Programs, .meld files, to format in place; - formats standard input to standard output")
        ->required();
    format->add_flag("--check", options.format.check, "Change nothing; list the files that would change, and exit with 1 if there are any");
    format->add_flag("--stdout", options.format.to_stdout, "Print the result instead of replacing the file");
    CLI::App* lsp =
        app.add_subcommand("lsp", "Serve an editor over standard input and output (Language Server Protocol).\nExample: meldc lsp --stdio");
    bool over_stdio = true;
    lsp->add_flag("--stdio", over_stdio, "Serve over standard input and output, which is the default and the only way");

    cli::add_common(app);
    if (const std::optional<int> code = cli::parse(app, argc, argv, choices(), {{"run", "meldsim"}, {"world", "meldsim"}})) return *code;
    std::optional<interrupt::TimeLimit> limit;
    if (options.timeout_seconds > 0) limit.emplace("meldc", options.timeout_seconds);
    if (options.no_graph) options.compile.worlds = check::Worlds::Any;
    if (options.graph) options.compile.worlds = check::Worlds::Graphs;
    if (*check)
        return run_check(
            {.files = options.files, .json = options.json, .how_many = how_many(options), .fix = options.fix, .compile = options.compile});
    if (*compile) return run_compile(options);
    if (*lsp) return run_language_server();
    if (*format) return run_format(options.format);
    return run_explain(options);
}

}  // namespace

int main(int argc, char** argv) {
    meld::prepare_standard_streams();
    // They end it as ever, and temporary files go.
    meld::interrupt::handle({SIGINT, SIGTERM, SIGHUP});
    meld::interrupt::end_by_signal();
    // There is something to say only of a time limit.
    meld::interrupt::set_last_words("");
    return meld::end_standard_output("meldc", meld::with_deep_stack("meldc", [&] { return run_program(argc, argv); }));
}
