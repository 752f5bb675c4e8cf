#include "runtime/driver/grade/grade_command.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <csignal>
#include <filesystem>

#include "runtime/base/files/output_file.h"
#include "runtime/base/files/standard_streams.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/base/terminal/log.h"
#include "runtime/base/units.h"
#include "runtime/cli/command_line.h"
#include "runtime/driver/grade/grade_page.h"
#include "runtime/driver/grade/grade_table.h"
#include "runtime/driver/grade/grading.h"
#include "runtime/driver/setup/print_error.h"

namespace meld::driver {

namespace {

namespace fs = std::filesystem;

// Beside the submissions.
std::string results_folder(const GradeOptions& options) {
    if (!options.folder.empty()) return options.folder;
    std::string path = fs::path(options.submissions).lexically_normal().string();
    while (path.size() > 1 && path.ends_with('/')) path.pop_back();
    if (path.ends_with(".meld")) path.resize(path.size() - 5);
    return (path == "." || path == ".." ? fs::absolute(path).lexically_normal().string() : path) + ".grades";
}

Result<void> write_results(const Grading& grading, const GradeOptions& options) {
    const auto write = [&](const std::string& name, const std::string& text) { return write_file(grading.folder + "/" + name, text); };
    std::error_code error;
    for (std::size_t i = 0; i < grading.submissions.size(); ++i) {
        const std::string folder = student_folder(grading.submissions[i]);
        fs::create_directories(grading.folder + "/" + folder, error);
        // Of a world that was revealed, or went wrong, before.
        for (std::size_t w = 0; w < grading.exercise.worlds.size(); ++w)
            if (grading.grades[i].runs[w].page.empty())
                fs::remove(fmt::format("{}/{}/{}.html", grading.folder, folder, grading.exercise.worlds[w].name), error);
        if (auto written = write(folder + "/index.html", student_page(grading, i, options.reveal)); !written) return written;
    }
    auto written = write("grades.csv", grade_csv(grading));
    if (written) written = write("grades.json", grade_json(grading, options.reveal));
    if (written) written = write("index.html", overview_page(grading));
    return written;
}

Result<int> grade(const GradeOptions& options) {
    Result<Exercise> exercise = read_exercise(options.exercise);
    if (!exercise) return tl::unexpected<Error>(exercise.error());
    Result<std::vector<Submission>> submissions = read_submissions(options.submissions, *exercise);
    if (!submissions) return tl::unexpected<Error>(submissions.error());
    const std::string folder = results_folder(options);
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) return fail(fmt::format("cannot make the folder {}: {}", folder, error.message()), "Give another one with --output");
    Grading grading{
        .exercise = std::move(*exercise), .submissions = std::move(*submissions), .folder = fs::canonical(folder, error).string()};
    if (auto done = grade_all(grading, options); !done) return tl::unexpected<Error>(done.error());
    if (!grading.without_network)
        log::warning("programs were run with access to the network, since this user may not make namespaces here");
    if (grading.interrupted) {
        log::warning("interrupted after {} runs: the same command goes on", grouped(grading.made + grading.kept));
        return interrupt::exit_code();
    }
    if (auto written = write_results(grading, options); !written) return tl::unexpected<Error>(written.error());
    std::string text;
    if (options.json) {
        text = grade_json(grading, options.reveal);
    } else if (!options.quiet) {
        text = grade_table(grading);
        text += fmt::format("{} runs: {} made now, {} there before\nresults: {}/index.html, grades.csv, students/\n",
                            grouped(grading.made + grading.kept), grouped(grading.made), grouped(grading.kept), folder);
    }
    if (auto printed = print(stdout, text); !printed) return tl::unexpected<Error>(printed.error());
    return static_cast<int>(ExitCode::Fine);
}

}  // namespace

CLI::App* add_grade(CLI::App& app, GradeOptions& grade) {
    CLI::App* g = app.add_subcommand("grade",
                                     "Grade what students have handed in: compile each program, run it in each world of an exercise, and "
                                     "write a table and a page for each student. What has been run stays: the same command goes on.\n"
                                     "Example: meldsim grade examples/exercises/flood submissions");
    g->add_option("EXERCISE", grade.exercise, "The folder of the exercise, with exercise.toml in it")->required();
    g->add_option("SUBMISSIONS", grade.submissions, "The folder with a .meld file or a folder for each student; or one such file")
        ->required();
    g->add_option("-o,--output", grade.folder, "The folder of the results; otherwise that beside the submissions, SUBMISSIONS.grades")
        ->type_name("DIR");
    g->add_option("--jobs", grade.jobs, "Programs at a time; otherwise one for each processor")
        ->check(cli::whole_number(1, 10000))
        ->type_name("INT");
    g->add_flag("--reveal", grade.reveal, "Say of hidden worlds as much as of others: what was expected and found, why, and a page");
    g->add_flag("--again", grade.again, "Run again what has ended at a limit of time or memory, or has crashed");
    g->add_flag("--json", grade.json, "Print the grades as JSON");
    g->add_flag("--quiet", grade.quiet, "Print no progress line and no table");
    return g;
}

int grade_command(const GradeOptions& options) {
    interrupt::handle({SIGINT, SIGTERM, SIGHUP});
    const Result<int> done = grade(options);
    return done ? *done : print_error(done.error());
}

}  // namespace meld::driver
