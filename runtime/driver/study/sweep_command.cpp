#include "runtime/driver/study/sweep_command.h"

#include <fmt/format.h>
#include <poll.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cctype>
#include <csignal>
#include <filesystem>
#include <optional>
#include <string>

#include "runtime/base/files/output_file.h"
#include "runtime/base/files/standard_streams.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/base/process/processors.h"
#include "runtime/base/terminal/log.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/base/units.h"
#include "runtime/cli/command_line.h"
#include "runtime/driver/session/debug.h"
#include "runtime/driver/session/view.h"
#include "runtime/driver/setup/print_error.h"
#include "runtime/driver/shrink/shrink.h"
#include "runtime/driver/study/row_pool.h"
#include "runtime/driver/study/shell_words.h"
#include "runtime/driver/study/study_plot.h"
#include "runtime/driver/study/study_report.h"
#include "runtime/driver/study/study_table.h"
#include "runtime/show/library/view_library.h"

namespace meld::driver {

namespace {

constexpr std::size_t kFailuresPrinted = 10;
constexpr int kWriteAttempts = 20;
constexpr int kWriteAgainAfter_ms = 100;

// rounds~n as a name of a file.
std::string file_name(std::string text) {
    std::ranges::replace_if(text, [](unsigned char c) { return !std::isalnum(c) && c != '.' && c != '@' && c != '_'; }, '-');
    return text;
}

class Sweep {
  public:
    Sweep(const SweepOptions& options, StudyPlan plan, RowStore store)
        : options_(options), plan_(std::move(plan)), store_(std::move(store)) {}

    Result<int> run();
    // The run of the row that is to be shown in the viewer.
    Result<RunOptions> shown_run() const;

  private:
    Result<int> print_command(std::size_t row) const;
    std::string failure_at(std::size_t row) const;
    Result<int> shrink();
    Result<int> write_job() const;
    Result<void> write_results(const StudyTable& table, const std::vector<StudyPlot>& plots);
    std::string said(const StudyTable& table, const PoolOutcome& outcome, std::size_t before) const;
    std::size_t rows_made() const;

    const SweepOptions& options_;
    StudyPlan plan_;
    RowStore store_;
};

// The command that makes the run again.
Result<int> Sweep::print_command(std::size_t row) const {
    std::string text = shell_words(plan_.command(plan_.rows()[row], ".")) + "\n";
    if (const std::string failure = failure_at(row); !failure.empty()) text += fmt::format("# {}\n", failure);
    if (auto printed = print(stdout, text); !printed) return tl::unexpected<Error>(printed.error());
    return 0;
}

// The first line of why it has failed; empty: it has not, or is not made yet.
std::string Sweep::failure_at(std::size_t row) const {
    const RowResult* const result = store_.find(plan_.rows()[row], plan_.study());
    const std::string failure = result == nullptr ? "" : failure_of(*result, plan_.study());
    return visible(failure.substr(0, failure.find('\n')));
}

// The run of a row, as it is looked at: forward and back, so that nothing ends it but its ticks.
Result<RunOptions> Sweep::shown_run() const {
    const Result<std::size_t> row = row_named(plan_, options_.show);
    if (!row) return tl::unexpected<Error>(row.error());
    RunOptions run = plan_.options(plan_.rows()[*row]);
    for (const BodiesOption& watch : kWatches) (run.*watch.bodies).clear();
    run.timeout_seconds = 0;
    run.quiet = options_.quiet;
    run.debug = {.view = options_.view};
    if (options_.quiet) return run;
    const std::string failure = failure_at(*row);
    const std::string text =
        fmt::format("row {}: {}\n", options_.show, failure.empty() ? shell_words(plan_.command(plan_.rows()[*row], ".")) : failure);
    if (auto printed = print(stdout, text); !printed) return tl::unexpected<Error>(printed.error());
    return run;
}

Result<int> Sweep::shrink() {
    const Result<std::size_t> row = row_named(plan_, options_.shrink);
    if (!row) return tl::unexpected<Error>(row.error());
    return shrink_row(options_, plan_, store_, *row);
}

std::size_t Sweep::rows_made() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(plan_.rows(), [&](const StudyRow& row) { return store_.find(row, plan_.study()) != nullptr; }));
}

// Others who are at their end at the same time write the same files.
template <class Write>
Result<void> write_beside_others(const Write& write) {
    Result<void> written = write();
    for (int attempt = 1; !written && attempt < kWriteAttempts; ++attempt) {
        poll(nullptr, 0, kWriteAgainAfter_ms);
        written = write();
    }
    return written;
}

Result<void> Sweep::write_results(const StudyTable& table, const std::vector<StudyPlot>& plots) {
    const std::string folder = store_.folder();
    auto written = write_beside_others([&] { return write_file(folder + "/rows.csv", csv_text(table)); });
    if (written) written = write_beside_others([&] { return write_sqlite(table, plan_.study(), folder + "/rows.sqlite"); });
    if (written) written = write_beside_others([&] { return write_file(folder + "/report.html", report_page(plan_, table, plots)); });
    return written;
}

// The script of a job array: its tasks are this command, and each takes what is left.
Result<int> Sweep::write_job() const {
    namespace fs = std::filesystem;
    std::error_code error;
    const std::string self = fs::read_symlink("/proc/self/exe", error).string();
    const std::string study = fs::absolute(options_.study).lexically_normal().string();
    const std::string folder = fs::absolute(store_.folder()).lexically_normal().string();
    const std::string path = store_.folder() + "/sweep.sbatch";
    const std::string script = fmt::format(
        "#!/bin/bash\n"
        "#SBATCH --job-name={}\n"
        "#SBATCH --array=1-{}\n"
        "#SBATCH --ntasks=1\n"
        "#SBATCH --cpus-per-task=1\n"
        "#SBATCH --output={}\n"
        "# Each task makes rows that are missing and that no other one is at, as many at a time as it has processors. The folder of the\n"
        "# results must be on a file system that all of them share.\n"
        "exec {} --jobs \"${{SLURM_CPUS_PER_TASK:-1}}\"\n",
        fs::path(study).stem().string(), options_.slurm, folder + "/task-%a.log",
        shell_words({self.empty() ? "meldsim" : self, "sweep", study, "-o", folder}));
    if (auto written = write_file(path, script); !written) return tl::unexpected<Error>(written.error());
    const std::string text = fmt::format("{} of {} runs are missing. Start the tasks by: sbatch {}\n",
                                         grouped(plan_.rows().size() - rows_made()), grouped(plan_.rows().size()), shell_words({path}));
    if (auto printed = print(stdout, text); !printed) return tl::unexpected<Error>(printed.error());
    return 0;
}

std::string Sweep::said(const StudyTable& table, const PoolOutcome& outcome, std::size_t before) const {
    const std::size_t status = *table.column("status"), reason = *table.column("reason");
    std::string failures;
    std::size_t failed = 0;
    for (const auto& row : table.rows) {
        if (text_of(row[status]) == "fine") continue;
        if (++failed > kFailuresPrinted) continue;
        const std::string why = text_of(row[reason]);
        failures += fmt::format("  row {}: {}\n", text_of(row[0]), visible(why.substr(0, why.find('\n'))));
    }
    if (failed > kFailuresPrinted) failures += fmt::format("  and {} more\n", grouped(failed - kFailuresPrinted));
    std::string text = fmt::format("{} run{}: {} made now, {} there before", grouped(plan_.rows().size()),
                                   plan_.rows().size() == 1 ? "" : "s", grouped(outcome.made), grouped(before));
    if (outcome.missing > 0) text += fmt::format(", {} missing", grouped(outcome.missing));
    text += failed > 0 ? fmt::format("; {} failed\n{}", grouped(failed), failures) : "; none failed\n";
    if (outcome.held > 0)
        text += fmt::format("{} of them waited for memory, of which one was expected to take {}: at most {} ran at a time\n",
                            grouped(outcome.held), format_bytes(outcome.held_bytes), outcome.most_at_once);
    return text + fmt::format("results: {0}/rows.csv, {0}/rows.sqlite, {0}/report.html\n", store_.folder());
}

Result<int> Sweep::run() {
    if (!options_.show.empty()) {
        const Result<std::size_t> row = row_named(plan_, options_.show);
        return row ? print_command(*row) : tl::unexpected<Error>(row.error());
    }
    if (!options_.shrink.empty()) return shrink();
    if (options_.slurm > 0) return write_job();
    if (!options_.plots.empty())
        if (auto there = show::need_view(); !there) return tl::unexpected<Error>(there.error());
    if (options_.again)
        for (const StudyRow& row : plan_.rows())
            if (const RowResult* result = store_.find(row, plan_.study()); result != nullptr && !failure_of(*result, plan_.study()).empty())
                store_.forget(row);
    const std::size_t before = rows_made();
    PoolOutcome outcome{.missing = plan_.rows().size() - before};
    if (!options_.as_is) {
        const int jobs = options_.jobs > 0 ? options_.jobs : std::max(1, processors() / plan_.study().threads);
        const std::uint64_t memory_bytes = options_.memory.empty() ? 0 : parse_bytes(options_.memory).value_or(0);
        const Result<PoolOutcome> made = make_rows(plan_, store_, {.jobs = jobs, .quiet = options_.quiet, .memory_bytes = memory_bytes});
        if (!made) return tl::unexpected<Error>(made.error());
        outcome = *made;
        if (outcome.missing == 0) store_.clean();
    }
    const StudyTable table = table_of(plan_, store_);
    if (auto written = write_results(table, {}); !written) return tl::unexpected<Error>(written.error());
    std::vector<StudyPlot> plots;
    std::string text;
    for (const std::string& what : options_.plots) {
        Result<StudyPlot> plot = plot_of(table, what);
        if (!plot) return tl::unexpected<Error>(plot.error());
        const std::string path = options_.image.empty() ? fmt::format("{}/{}.svg", store_.folder(), file_name(what)) : options_.image;
        if (auto written = write_plot(*plot, path); !written) return tl::unexpected<Error>(written.error());
        text += fmt::format("{}plot: {}\n", plot->said, path);
        plots.push_back(std::move(*plot));
    }
    if (!plots.empty())
        if (auto written = write_results(table, plots); !written) return tl::unexpected<Error>(written.error());
    if (options_.table) text += summary_text(table);
    if (!options_.quiet && !options_.table && options_.plots.empty()) text += said(table, outcome, before);
    if (auto printed = print(stdout, text); !printed) return tl::unexpected<Error>(printed.error());
    if (outcome.interrupted) {
        log::warning("interrupted: the same command goes on with the {} runs that are missing", grouped(outcome.missing));
        return interrupt::exit_code();
    }
    const std::size_t status = *table.column("status");
    const bool failed = std::ranges::any_of(table.rows, [&](const auto& row) { return text_of(row[status]) != "fine"; });
    return static_cast<int>(failed ? ExitCode::PropertyFailed : ExitCode::Fine);
}

Result<Sweep> open_sweep(const SweepOptions& options) {
    if (!options.memory.empty())
        if (const auto bytes = parse_bytes(options.memory); !bytes) return fail("--memory: " + bytes.error().problem);
    Result<Study> study = read_study(options.study);
    if (!study) return tl::unexpected<Error>(study.error());
    Result<RowStore> store = RowStore::open(results_folder(options.study, options.folder));
    if (!store) return tl::unexpected<Error>(store.error());
    Result<StudyPlan> plan = StudyPlan::make(std::move(*study), store->worlds_folder());
    if (!plan) return tl::unexpected<Error>(plan.error());
    return Sweep(options, std::move(*plan), std::move(*store));
}

Result<int> sweep(const SweepOptions& options) {
    Result<Sweep> opened = open_sweep(options);
    return opened ? opened->run() : tl::unexpected<Error>(opened.error());
}

// Nothing of the study stays open meanwhile.
int show_row(const SweepOptions& options) {
    if (const auto there = show::need_view(); !there) return print_error(there.error());
    Result<RunOptions> run = [&]() -> Result<RunOptions> {
        const Result<Sweep> opened = open_sweep(options);
        return opened ? opened->shown_run() : tl::unexpected<Error>(opened.error());
    }();
    // It is a program: no command line of a checkpoint is to be read.
    return run ? debug_command(std::move(*run), "", [](const auto&) { return std::optional<RunOptions>(); }) : print_error(run.error());
}

}  // namespace

CLI::App* add_sweep(CLI::App& app, SweepOptions& sweep) {
    CLI::App* s = app.add_subcommand("sweep",
                                     "Make the runs of a study, those that are missing, and write a table with a row for each. What has "
                                     "been made stays: the same command goes on.\nExample: meldsim sweep study.toml --table");
    s->add_option("STUDY", sweep.study, "The study, a .toml file: programs, worlds, seeds, parameters and measures")->required();
    s->add_option("-o,--output", sweep.folder, "The folder of the results; otherwise that beside the study, STUDY.results")
        ->type_name("DIR");
    s->add_option("--jobs", sweep.jobs, "Runs at a time; otherwise one for each processor")
        ->check(cli::whole_number(1, 10000))
        ->type_name("INT");
    s->add_flag("--table", sweep.table, "Print each combination of parameters: its runs, and of each measure the median and quartiles");
    s->add_option("--plot", sweep.plots,
                  "Plot a measure over a parameter or another measure, as rounds~n: medians with quartiles, the power law that fits, and a "
                  "test of two programs; 'rounds~n|world,loss' has a line for each combination of these columns alone; repeatable")
        ->type_name("Y~X")
        ->take_all()
        ->allow_extra_args(false);
    s->add_option("--image", sweep.image, "The file of the plot, .svg or .png; otherwise Y-X.svg in the folder of the results")
        ->type_name("FILE")
        ->needs("--plot");
    s->add_option("--memory", sweep.memory,
                  "Memory that the runs may take together, as 16GiB; otherwise what is free. A run that is expected to need more than is "
                  "left waits; one always runs")
        ->type_name("BYTES");
    CLI::Option* const show =
        s->add_option("--show", sweep.show, "Run nothing else: show the run of this row in the viewer, with its number as in the table");
    show->type_name("ROW");
    s->add_flag("--print", sweep.print, "Of --show: print the command that makes the row again, and show nothing")->needs(show);
    add_serving(*s, sweep.view, show);
    CLI::Option* const shrink = s->add_option("--shrink", sweep.shrink,
                                              "Make a small world in which this failed row still fails in the same way: with the fewest "
                                              "catoms, links, events and ticks, and no chance in its network if possible");
    shrink->type_name("ROW")->excludes("--show");
    s->add_option("--tries", sweep.tries, "Of --shrink: make at most so many runs")
        ->check(cli::whole_number(1, 1'000'000'000))
        ->type_name("INT")
        ->capture_default_str()
        ->needs(shrink);
    s->add_option("--still", sweep.still, "Of --shrink: a body, in Meld, that must hold at the end of each smaller run too")
        ->type_name("BODY")
        ->needs(shrink);
    s->add_option("--slurm", sweep.slurm, "Run nothing: write the script of a job array of so many tasks, which share what is missing")
        ->check(cli::whole_number(1, 100000))
        ->type_name("TASKS");
    s->add_flag("--as-is", sweep.as_is, "Run nothing: take the rows that there are");
    s->add_flag("--again", sweep.again, "Make the rows that have failed again");
    s->add_flag("--quiet", sweep.quiet, "Print no progress line and no summary");
    return s;
}

int sweep_command(const SweepOptions& options) {
    if (!options.show.empty() && !options.print) return show_row(options);
    interrupt::handle({SIGINT, SIGTERM, SIGHUP});
    const Result<int> done = sweep(options);
    return done ? *done : print_error(done.error());
}

}  // namespace meld::driver
