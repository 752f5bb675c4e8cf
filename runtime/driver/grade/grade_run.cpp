#include "runtime/driver/grade/grade_run.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "runtime/ask/query/query.h"
#include "runtime/ask/why/why.h"
#include "runtime/driver/run/run.h"
#include "runtime/driver/run/simulate.h"
#include "runtime/driver/setup/inputs.h"
#include "runtime/module/load/module.h"
#include "runtime/results/timeline/timeline.h"

namespace meld::driver {

namespace {

using Json = nlohmann::ordered_json;

// A page with more frames is slow to turn.
constexpr std::int64_t kMostFrames = 200;
constexpr std::size_t kWhySteps = 3;

std::string text_of(const Json& json) { return json.dump(-1, ' ', true, Json::error_handler_t::replace); }

RunOptions options_of(const Exercise& exercise, const Submission& submission, const ExerciseWorld& world) {
    RunOptions options;
    options.program = submission.program;
    options.world = world.path;
    options.library_paths = exercise.library;
    options.quiet = true;
    if (world.ticks) options.ticks = *world.ticks;
    if (world.seed) options.seed = *world.seed;
    options.limits = {fmt::format("ticks={}", std::max(exercise.limits.ticks, static_cast<std::uint64_t>(world.ticks.value_or(0))))};
    return options;
}

Json failed(const std::string& outcome, const std::string& reason) {
    return {{"outcome", outcome}, {"reason", reason}, {"tick", 0}, {"checks", Json::array()}};
}

// Looks whether what is expected holds, after the ticks that the exercise names and at the end.
class Checking : public RunObserver {
  public:
    Checking(const ExerciseWorld& world, const ModuleInfo& module) : world_(world) {
        for (const ExerciseCheck& check : world.checks) {
            Result<inspect::Program> question = inspect::read_question(module, check.body);
            answers_.push_back({{"name", check.name}, {"fine", true}, {"found", ""}});
            if (!question) mark(answers_.size() - 1, -1, question.error().message());
            questions_.push_back(question ? std::optional(std::move(*question)) : std::nullopt);
        }
    }

    // What is never to hold, and can be asked, is watched by the run itself.
    std::vector<std::string> watched() const {
        std::vector<std::string> bodies;
        for (std::size_t i = 0; i < questions_.size(); ++i)
            if (world_.checks[i].never && questions_[i]) bodies.push_back(world_.checks[i].body);
        return bodies;
    }

    void begin(sim::Simulation& simulation) override;
    Result<void> after_tick(sim::Subdomain& subdomain) {
        for (std::size_t i = 0; i < questions_.size(); ++i) {
            const std::vector<std::int64_t>& ticks = world_.checks[i].ticks;
            if (std::ranges::find(ticks, subdomain.tick()) != ticks.end())
                if (auto done = look(subdomain, i); !done) return done;
        }
        return {};
    }

    Result<void> end(sim::Simulation& simulation, const inspect::Watches* watches, bool failed) override {
        tick_ = simulation.summary().ticks;
        if (failed) return {};
        std::size_t watched = 0;
        for (std::size_t i = 0; i < questions_.size(); ++i) {
            if (!questions_[i]) continue;
            const ExerciseCheck& check = world_.checks[i];
            if (check.never) {
                const inspect::Watches::Outcome& outcome = watches->outcomes()[watched++];
                if (!outcome.wrong) continue;
                const std::size_t line = std::min(outcome.found.find('\n'), outcome.found.size());
                mark(i, -1, outcome.found.substr(0, line));
                answers_[i]["why"] = outcome.found.substr(std::min(line + 1, outcome.found.size()));
                continue;
            }
            const auto seen = [&](std::int64_t tick) { return tick <= simulation.subdomain().tick(); };
            if (check.ticks.empty()) {
                if (auto done = look(simulation.subdomain(), i); !done) return done;
            } else if (!std::ranges::all_of(check.ticks, seen)) {
                // A run that is over stays as it is.
                if (auto done = look(simulation.subdomain(), i); !done) return done;
            }
        }
        return {};
    }

    Json answer() const {
        const bool fine = std::ranges::all_of(answers_, [](const Json& each) { return each["fine"].get<bool>(); });
        return {{"outcome", fine ? "fine" : "wrong"}, {"reason", ""}, {"tick", tick_}, {"checks", answers_}};
    }
    std::int64_t tick() const { return tick_; }

  private:
    void mark(std::size_t check, std::int64_t tick, const std::string& found) {
        if (!answers_[check]["fine"].get<bool>()) return;
        answers_[check]["fine"] = false;
        answers_[check]["found"] = found;
        if (tick >= 0) answers_[check]["tick"] = tick;
    }
    Result<void> look(sim::Subdomain& subdomain, std::size_t check) {
        if (!questions_[check] || world_.checks[check].never) return {};
        const Result<inspect::Table> table = inspect::query(subdomain, *questions_[check]);
        if (!table && table.error().code == ExitCode::Interrupted) return tl::unexpected<Error>(table.error());
        if (!table)
            mark(check, -1, table.error().message());
        else if (table->rows() == 0)
            mark(check, subdomain.tick(), fmt::format("it does not hold after tick {}", subdomain.tick()));
        return {};
    }

    const ExerciseWorld& world_;
    std::vector<std::optional<inspect::Program>> questions_;  // By check; nothing: the program has no such predicates.
    std::vector<Json> answers_;
    std::int64_t tick_ = 0;
};

class TickChecks : public sim::SimModule {
  public:
    explicit TickChecks(Checking& of) : of_(of) {}
    Result<void> after(sim::Subdomain& subdomain) override { return of_.after_tick(subdomain); }
    // It keeps nothing in the run, so that what may never hold can be explained in a copy of it.
    Result<void> saveable() const override { return {}; }

  private:
    Checking& of_;
};

void Checking::begin(sim::Simulation& simulation) {
    if (std::ranges::any_of(world_.checks, [](const ExerciseCheck& check) { return !check.ticks.empty(); }))
        simulation.add(std::make_unique<TickChecks>(*this), "(checks)");
}

}  // namespace

std::string read_and_compile(const Exercise& exercise, const Submission& submission) {
    const Reading reading = read_program(submission, exercise);
    Json out = {{"problem", reading.problem}, {"messages", ""}, {"likeness", fmt::format("{:016x}", reading.likeness)}};
    for (const ExerciseWorld& world : exercise.worlds) {
        if (!out["problem"].get<std::string>().empty()) break;
        RunOptions options = options_of(exercise, submission, world);
        options.timeout_seconds = exercise.limits.compile_seconds;
        std::string messages;
        const Result<std::string> module = compile_program(options, &messages);
        if (module) continue;
        out["problem"] = module.error().problem.empty() ? "it does not compile" : "it does not compile: " + module.error().message();
        out["messages"] = messages;
    }
    return text_of(out);
}

std::string run_in_world(const Exercise& exercise, const Submission& submission, const ExerciseWorld& world) {
    RunOptions options = options_of(exercise, submission, world);
    std::string messages;
    const Result<std::string> path = compile_program(options, &messages);
    if (!path) return text_of(failed("error", path.error().message() + messages));
    const Result<Module> module = load_module(*path, kAbiVersion);
    if (!module) return text_of(failed("error", module.error().message()));
    Checking checking(world, *static_cast<const ModuleInfo*>(module->table()));
    options.never = checking.watched();
    const auto comm = comm::make_single();
    const Result<int> done = simulate(options, *comm, *path, &checking);
    if (done) return text_of(checking.answer());
    const bool limit = done.error().code == ExitCode::LimitHit;
    // How to raise the limit is for whoever runs the program alone; what follows says what still went on.
    const std::string& more = done.error().suggestion;
    const std::size_t line = more.find('\n');
    Json out = limit ? failed("limit", done.error().problem + (line == std::string::npos ? "" : more.substr(line)))
                     : failed("error", done.error().message());
    // Where the exercise lies on this machine is nobody's concern.
    std::string reason = out["reason"];
    const std::string folder = exercise.folder + "/";
    for (std::size_t at = 0; (at = reason.find(folder, at)) != std::string::npos;) reason.erase(at, folder.size());
    out["reason"] = reason;
    out["tick"] = checking.tick();
    return text_of(out);
}

std::string explain_check(const Exercise& exercise, const Submission& submission, const ExerciseWorld& world, std::size_t check,
                          std::int64_t tick) {
    const RunOptions options = options_of(exercise, submission, world);
    const auto explained = [&]() -> Result<std::string> {
        std::string messages;
        const Result<std::string> path = compile_program(options, &messages);
        if (!path) return tl::unexpected<Error>(path.error());
        const auto comm = comm::make_single();
        Result<Inputs> inputs = read_inputs(options, *comm, *path);
        if (!inputs) return tl::unexpected<Error>(inputs.error());
        if (auto counted = count_catoms(options, *comm, *inputs); !counted) return tl::unexpected<Error>(counted.error());
        const auto make = [&] {
            return std::make_unique<sim::Simulation>(inputs->info(), inputs->world, inputs->target, *comm, options.threads);
        };
        timeline::Timeline timeline(make, inputs->registry, {.limits = {options.ticks, options.strict}, .history_bytes = 0});
        if (auto there = timeline.start(); !there) return tl::unexpected<Error>(there.error());
        if (auto there = timeline.to(tick); !there) return tl::unexpected<Error>(there.error());
        const auto why = inspect::why_not_body(timeline, world.checks[check].body, {.depth = kWhySteps, .origins = false});
        if (!why) return tl::unexpected<Error>(why.error());
        return why->to_text();
    };
    const Result<std::string> why = explained();
    return text_of({{"why", why ? *why : "it cannot be explained: " + why.error().message()}});
}

std::string share_run(const Submission& submission, const Exercise& exercise, const ExerciseWorld& world, std::int64_t last_tick,
                      const std::string& file) {
    const std::int64_t last = std::max<std::int64_t>(last_tick, 1);
    std::vector<std::string> words = {"meldsim",
                                      "view",
                                      submission.program,
                                      "--world",
                                      world.path,
                                      "--share",
                                      file,
                                      "--ticks",
                                      std::to_string(last),
                                      "--every",
                                      std::to_string((last + kMostFrames - 1) / kMostFrames),
                                      "--facts",
                                      "all",
                                      "--quiet"};
    for (const std::string& folder : exercise.library) words.insert(words.end(), {"-I", folder});
    if (world.seed) words.insert(words.end(), {"--seed", std::to_string(*world.seed)});
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    execv("/proc/self/exe", arguments.data());
    return "it cannot be started";
}

}  // namespace meld::driver
