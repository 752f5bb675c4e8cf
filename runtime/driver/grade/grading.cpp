#include "runtime/driver/grade/grading.h"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <deque>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "runtime/base/files/output_file.h"
#include "runtime/base/hash.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/base/process/processors.h"
#include "runtime/base/process/stage_clock.h"
#include "runtime/base/terminal/progress.h"
#include "runtime/base/units.h"
#include "runtime/base/version.h"
#include "runtime/driver/grade/confined.h"
#include "runtime/driver/grade/grade_run.h"
#include "runtime/driver/grade/grade_store.h"

namespace meld::driver {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Is = ConfinedEnd::Is;

constexpr int kLook_ms = 20;
constexpr std::uint64_t kCompileMemory_bytes = std::uint64_t{2} << 30;
constexpr std::uint64_t kCompileOutput_bytes = std::uint64_t{1} << 20;
constexpr std::uint64_t kMostWritten_bytes = std::uint64_t{1} << 30;
// A page takes the run, its frames and the facts of all ticks.
constexpr double kPageFactor = 3, kPageMore_s = 20;

enum class Step { Read, Run, Explain, Page };

struct Task {
    Step step = Step::Read;
    std::size_t submission = 0, world = 0, check = 0;
};

// What an end means for the run of a program, and why, in words.
std::pair<std::string, std::string> in_words(const ConfinedEnd& end, const Confines& confines) {
    switch (end.is) {
        case Is::OutOfTime:
            return {"time", fmt::format("it takes more than {} of processor time", format_duration(confines.seconds))};
        case Is::OutOfMemory:
            return {"memory", fmt::format("it needs more than {} of memory", format_bytes(confines.memory))};
        case Is::TooMuchOutput:
            return {"output", fmt::format("it prints more than {}", format_bytes(confines.output))};
        default:
            return {"crash", "it crashes, " + (end.how.empty() ? "without an answer" : end.how)};
    }
}

// Up to where a run is shown: its end, the tick before an error, or, of a run that came to no end, the first few.
std::int64_t last_tick_of_page(const GradedRun& run) {
    constexpr std::int64_t kFew = 5;
    if (run.outcome == "wrong" || run.outcome == "limit") return run.tick;
    return run.outcome == "error" ? run.tick - 1 : kFew;
}

class Grader {
  public:
    Grader(Grading& grading, const GradeOptions& options, GradeStore store)
        : g_(grading), options_(options), store_(std::move(store)), begun_(seconds_now()) {
        jobs_ = static_cast<std::size_t>(options.jobs > 0 ? options.jobs : std::max(1, processors()));
        if (!options.quiet) progress_.emplace();
    }

    Result<void> run();

  private:
    struct Running {
        Task task;
        Confines confines;
        Confined process;
    };

    const Submission& submission(const Task& task) const { return g_.submissions[task.submission]; }
    const ExerciseWorld& world(const Task& task) const { return g_.exercise.worlds[task.world]; }
    bool shown(const Task& task) const { return options_.reveal || !world(task).hidden; }
    std::string scratch_folder(const Submission& each) const { return fmt::format("{}/scratch/{}", g_.folder, each.file); }

    std::uint64_t key(const Task& task) const;
    Confines confines(const Task& task) const;
    std::string work(const Task& task) const;
    Result<void> lay_out(const Submission& each) const;
    Result<void> start_more();
    Result<void> collect();
    Result<void> finish(const Task& task, const Json& answer);
    Json answer_of(const Task& task, const Confines& confines, const ConfinedEnd& end) const;
    void take_run(const Task& task, const Json& answer);
    std::string line() const;

    Grading& g_;
    const GradeOptions& options_;
    GradeStore store_;
    std::deque<Task> todo_;
    std::vector<Running> running_;
    std::optional<Progress> progress_;
    std::size_t jobs_ = 1;
    double begun_;
};

std::uint64_t Grader::key(const Task& task) const {
    std::uint64_t hash = hash_text(kVersion);
    for (const std::uint64_t part :
         {g_.exercise.hash, submission(task).hash, hash_text(submission(task).program), static_cast<std::uint64_t>(task.step),
          static_cast<std::uint64_t>(task.world), static_cast<std::uint64_t>(task.check)})
        hash = hash_combine(hash, part);
    return hash;
}

Confines Grader::confines(const Task& task) const {
    const ExerciseLimits& limits = g_.exercise.limits;
    Confines c{.folder = scratch_folder(submission(task)),
               .seconds = limits.seconds,
               .memory = limits.memory,
               .output = limits.output,
               .file_bytes = kMostWritten_bytes};
    if (task.step == Step::Read) {
        c.seconds = limits.compile_seconds * static_cast<double>(g_.exercise.worlds.size());
        c.memory = kCompileMemory_bytes;
        c.output = kCompileOutput_bytes;
    } else if (task.step != Step::Run) {
        c.seconds = kPageFactor * limits.seconds + kPageMore_s;
        c.memory = std::max(limits.memory, kCompileMemory_bytes);
    }
    return c;
}

// In the process of the task.
std::string Grader::work(const Task& task) const {
    const Submission& each = submission(task);
    switch (task.step) {
        case Step::Read:
            return read_and_compile(g_.exercise, each);
        case Step::Run:
            return run_in_world(g_.exercise, each, world(task));
        case Step::Explain:
            return explain_check(g_.exercise, each, world(task), task.check,
                                 g_.grades[task.submission].runs[task.world].checks[task.check].tick);
        case Step::Page:
            return share_run(each, g_.exercise, world(task), last_tick_of_page(g_.grades[task.submission].runs[task.world]),
                             store_.page(key(task)));
    }
    return "";
}

// The submission's files, in a folder of their own.
Result<void> Grader::lay_out(const Submission& each) const {
    std::error_code error;
    const std::string folder = scratch_folder(each);
    fs::remove_all(folder, error);
    for (const auto& [name, text] : each.files) {
        const fs::path path = fs::path(folder) / name;
        fs::create_directories(path.parent_path(), error);
        if (auto written = write_file(path.string(), text); !written) return written;
    }
    return {};
}

Json Grader::answer_of(const Task& task, const Confines& confines, const ConfinedEnd& end) const {
    Json answer = Json::parse(end.is == Is::Answered ? end.answer : "", nullptr, false);
    const auto [outcome, reason] = in_words(end, confines);
    const bool whole = answer.is_object();
    switch (task.step) {
        case Step::Read:
            if (!whole)
                answer = {{"problem",
                           end.is == Is::Crashed ? fmt::format("the compiler crashes at it, {}", end.how) : "to compile it, " + reason},
                          {"messages", end.said},
                          {"likeness", "0"}};
            break;
        case Step::Run:
            if (!whole) answer = {{"outcome", outcome}, {"reason", reason}, {"tick", 0}, {"checks", Json::array()}};
            answer["said"] = end.said;
            answer["seconds"] = end.seconds;
            break;
        case Step::Explain:
            if (!whole) answer = {{"why", "it cannot be explained: " + reason}};
            break;
        case Step::Page: {
            std::error_code error;
            const bool made = end.is == Is::Answered && fs::exists(store_.page(key(task)), error);
            answer = {{"made", made}};
            break;
        }
    }
    return answer;
}

void Grader::take_run(const Task& task, const Json& answer) {
    GradedRun& run = g_.grades[task.submission].runs[task.world];
    run = {.outcome = answer.value("outcome", "crash"),
           .reason = answer.value("reason", ""),
           .tick = answer.value("tick", std::int64_t{0}),
           .said = answer.value("said", ""),
           .seconds = answer.value("seconds", 0.0)};
    for (const Json& check : answer.value("checks", Json::array()))
        run.checks.push_back({.fine = check.value("fine", false),
                              .found = check.value("found", ""),
                              .why = check.value("why", ""),
                              .tick = check.value("tick", std::int64_t{-1})});
    if (run.outcome == "fine") g_.grades[task.submission].points += world(task).points;
}

// What follows from an answer: further tasks.
Result<void> Grader::finish(const Task& task, const Json& answer) {
    Grade& grade = g_.grades[task.submission];
    const auto add = [&](Task next) {
        next.submission = task.submission;
        todo_.push_front(next);
    };
    switch (task.step) {
        case Step::Read:
            grade.problem = answer.value("problem", "");
            grade.messages = answer.value("messages", "");
            grade.likeness = std::strtoull(answer.value("likeness", "0").c_str(), nullptr, 16);
            if (grade.problem.empty())
                for (std::size_t w = g_.exercise.worlds.size(); w-- > 0;) add({.step = Step::Run, .world = w});
            break;
        case Step::Run: {
            take_run(task, answer);
            GradedRun& run = grade.runs[task.world];
            if (run.outcome == "fine" || !shown(task)) break;
            add({.step = Step::Page, .world = task.world});
            for (std::size_t c = 0; c < run.checks.size(); ++c)
                if (!run.checks[c].fine && run.checks[c].tick >= 0 && run.checks[c].why.empty())
                    add({.step = Step::Explain, .world = task.world, .check = c});
            break;
        }
        case Step::Explain:
            grade.runs[task.world].checks[task.check].why = answer.value("why", "");
            break;
        case Step::Page: {
            if (!answer.value("made", false)) break;
            const std::string name = world(task).name + ".html";
            const fs::path to = fs::path(g_.folder) / student_folder(submission(task)) / name;
            std::error_code error;
            fs::create_directories(to.parent_path(), error);
            fs::remove(to, error);
            fs::create_hard_link(store_.page(key(task)), to, error);
            if (error) fs::copy_file(store_.page(key(task)), to, fs::copy_options::overwrite_existing, error);
            if (error) return fail(fmt::format("cannot write {}: {}", to.string(), error.message()), "", ExitCode::LimitHit);
            grade.runs[task.world].page = name;
            break;
        }
    }
    return {};
}

// Ends that another try may change: they depend on the machine.
bool ended_at_limit(const Json& answer) {
    const std::string outcome = answer.value("outcome", "");
    return outcome == "time" || outcome == "memory" || outcome == "crash";
}

Result<void> Grader::start_more() {
    while (running_.size() < jobs_ && !todo_.empty()) {
        const Task task = todo_.front();
        todo_.pop_front();
        std::optional<Json> known = store_.find(key(task));
        std::error_code error;
        if (known && task.step == Step::Page && known->value("made", false) && !fs::exists(store_.page(key(task)), error)) known.reset();
        if (known && options_.again && task.step == Step::Run && ended_at_limit(*known)) known.reset();
        if (known) {
            if (task.step == Step::Run) ++g_.kept;
            if (auto done = finish(task, *known); !done) return done;
            continue;
        }
        const Confines c = confines(task);
        Result<Confined> started = Confined::start([&] { return work(task); }, c);
        if (!started) return tl::unexpected<Error>(started.error());
        running_.push_back({task, c, std::move(*started)});
    }
    return {};
}

Result<void> Grader::collect() {
    std::vector<pollfd> ends;
    for (const Running& each : running_) ends.push_back({each.process.descriptor(), POLLIN, 0});
    poll(ends.data(), ends.size(), kLook_ms);
    for (std::size_t i = running_.size(); i-- > 0;) {
        const std::optional<ConfinedEnd> end = running_[i].process.look();
        if (!end) continue;
        const Running ended = std::move(running_[i]);
        running_.erase(running_.begin() + static_cast<std::ptrdiff_t>(i));
        const Json answer = answer_of(ended.task, ended.confines, *end);
        if (auto kept = store_.keep(key(ended.task), answer); !kept) return kept;
        if (ended.task.step == Step::Run) ++g_.made;
        if (auto done = finish(ended.task, answer); !done) return done;
    }
    return {};
}

std::string Grader::line() const {
    const auto graded = static_cast<std::size_t>(std::ranges::count_if(g_.grades, [](const Grade& g) { return g.problem.empty(); }));
    const std::size_t all = graded * g_.exercise.worlds.size(), done = g_.made + g_.kept;
    std::string text = fmt::format("{} submissions, {} of {} runs", grouped(g_.grades.size()), grouped(done), grouped(all));
    if (g_.made > 0 && done < all)
        text += fmt::format(", {} left",
                            format_duration((seconds_now() - begun_) * static_cast<double>(all - done) / static_cast<double>(g_.made)));
    return text;
}

Result<void> Grader::run() {
    const interrupt::Answering patiently(interrupt::Answer::Patiently);
    g_.grades.resize(g_.submissions.size());
    for (std::size_t i = 0; i < g_.submissions.size(); ++i) {
        g_.grades[i].runs.resize(g_.exercise.worlds.size());
        g_.grades[i].problem = g_.submissions[i].problem;
        if (!g_.grades[i].problem.empty()) continue;
        if (auto laid = lay_out(g_.submissions[i]); !laid) return laid;
        todo_.push_back({.step = Step::Read, .submission = i});
    }
    while (!todo_.empty() || !running_.empty()) {
        if (interrupt::received() != 0) {
            g_.interrupted = true;
            running_.clear();
            return {};
        }
        if (auto started = start_more(); !started) return started;
        if (auto collected = collect(); !collected) return collected;
        if (progress_) progress_->update([&] { return line(); });
    }
    return {};
}

// Copies are looked for among those that have been read; that of the starting program is none.
void find_copies(Grading& g, std::uint64_t start, const std::vector<std::uint64_t>& solutions) {
    std::map<std::uint64_t, std::vector<std::size_t>> alike;
    for (std::size_t i = 0; i < g.grades.size(); ++i) {
        Grade& grade = g.grades[i];
        if (grade.likeness == 0) continue;
        grade.as_start = grade.likeness == start;
        grade.as_solution = std::ranges::find(solutions, grade.likeness) != solutions.end();
        if (!grade.as_start) alike[grade.likeness].push_back(i);
    }
    for (const auto& [hash, all] : alike)
        for (const std::size_t one : all)
            for (const std::size_t other : all)
                if (one != other) g.grades[one].same_as.push_back(other);
}

// The likeness of programs of the exercise, which nobody has handed in.
std::uint64_t likeness_of(const Exercise& exercise, const std::string& path) {
    const auto read = read_submissions(path, exercise);
    if (!read || read->empty() || !read->front().problem.empty()) return 0;
    return read_program(read->front(), exercise).likeness;
}

}  // namespace

std::string student_folder(const Submission& submission) { return "students/" + submission.file; }

Result<void> grade_all(Grading& grading, const GradeOptions& options) {
    Result<GradeStore> store = GradeStore::open(grading.folder + "/kept");
    if (!store) return tl::unexpected<Error>(store.error());
    grading.without_network = can_cut_network();
    if (auto done = Grader(grading, options, std::move(*store)).run(); !done) return done;
    std::vector<std::uint64_t> solutions;
    std::error_code error;
    for (fs::directory_iterator each(grading.exercise.folder + "/solution", error), end; !error && each != end; each.increment(error))
        if (each->path().extension() == ".meld") solutions.push_back(likeness_of(grading.exercise, each->path().string()));
    find_copies(grading, likeness_of(grading.exercise, grading.exercise.program), solutions);
    return {};
}

}  // namespace meld::driver
