#include "runtime/driver/debug.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <limits>
#include <memory>
#include <utility>

#include "runtime/base/bytes.h"
#include "runtime/base/interrupt.h"
#include "runtime/base/log.h"
#include "runtime/base/progress.h"
#include "runtime/base/standard_streams.h"
#include "runtime/base/units.h"
#include "runtime/base/visible.h"
#include "runtime/comm/outcome.h"
#include "runtime/compare/compare.h"
#include "runtime/debug/input.h"
#include "runtime/debug/session.h"
#include "runtime/driver/checkpoints.h"
#include "runtime/driver/replay.h"
#include "runtime/driver/report.h"
#include "runtime/driver/run.h"
#include "runtime/driver/scratch.h"
#include "runtime/driver/tell.h"
#include "runtime/sim/state/checkpoint_folder.h"
#include "runtime/timeline/timeline.h"

namespace meld::driver {

namespace {

namespace fs = std::filesystem;

// So many lines of facts are shown on a terminal.
constexpr std::uint64_t kLinesOnTerminal = 40;

// In place of a module of the run that writes: what that has kept in a checkpoint is read and forgotten.
class Silent : public sim::SimModule {
  public:
    bool runnable() const override { return false; }
    Result<void> saveable() const override { return {}; }
    void load_catoms(sim::Subdomain&, std::span<const tuple::SavedCatom>, ByteReader& in) override { in.read_bytes(in.left()); }
    Result<void> load_rest(sim::Subdomain&, ByteReader& in) override {
        in.read_bytes(in.left());
        return {};
    }
};

// The modules that write, of the run of a checkpoint, as simulate() adds and names them.
std::vector<std::string> writing_modules(const RunOptions& options) {
    std::vector<std::string> names;
    if (options.resume.empty()) return names;
    if (!options.record.empty()) names.emplace_back("recorder");
    names.insert(names.end(), {"printer", "watcher"});
    if (!options.digest.empty()) names.emplace_back("digests");
    return names;
}

// The checkpoint at which a session begins, if it does not begin with the world. Every process calls it.
Result<std::unique_ptr<sim::OpenCheckpoint>> open_beginning(const RunOptions& options, const std::vector<Claim>& claims,
                                                            const world::World& world, comm::Communicator& comm) {
    if (options.resume.empty()) return nullptr;
    Result<sim::OpenCheckpoint> newest = sim::open_newest(options.resume, comm);
    if (!newest) return tl::unexpected<Error>(newest.error());
    const sim::Checkpoint& checkpoint = newest->checkpoint;
    if (!checkpoint.passed_over.empty() && comm.process() == 0)
        log::warning("a newer checkpoint is not whole, and the session begins with that of tick {}: {}", checkpoint.manifest.tick,
                     checkpoint.passed_over);
    if (const std::string other = sim::difference(checkpoint.manifest.run, identity(options, claims, world)); !other.empty())
        return fail(fmt::format("the run in {} cannot be looked at: {}", options.resume, other), "Put back what it was started with",
                    ExitCode::RecordingRefused);
    return std::make_unique<sim::OpenCheckpoint>(std::move(*newest));
}

// Shows how far the run is while a command is carried out, and asks it to stop when a signal has come.
class OnTheWay {
  public:
    OnTheWay(timeline::Timeline& timeline, bool shows, std::int64_t last_tick) : timeline_(timeline) {
        if (shows) progress_.emplace();
        timeline_.each([this, last_tick](sim::Simulation& simulation) {
            if (interrupt::received() != 0) simulation.subdomain().request_stop();
            if (!progress_) return;
            progress_->update([&] {
                const std::chrono::duration<double> since = std::chrono::steady_clock::now() - begin_;
                return progress_line(simulation, since.count(), last_tick);
            });
        });
    }
    ~OnTheWay() { timeline_.each({}); }
    OnTheWay(const OnTheWay&) = delete;
    OnTheWay& operator=(const OnTheWay&) = delete;

  private:
    timeline::Timeline& timeline_;
    std::optional<Progress> progress_;
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

// Process 0 reads commands and prints answers, all carry them out.
class Conversation {
  public:
    Conversation(const RunOptions& options, comm::Communicator& comm, timeline::Timeline& timeline, std::optional<debug::Input> input)
        : options_(options),
          comm_(comm),
          timeline_(timeline),
          input_(std::move(input)),
          session_(timeline, !options.json && options.debug->shown ? kLinesOnTerminal : std::numeric_limits<std::uint64_t>::max()) {}

    Result<void> hold() {
        while (true) {
            const Result<std::optional<std::string>> line = next_line();
            if (!line) return tl::unexpected<Error>(line.error());
            if (!*line) return {};
            const Result<debug::Command> command = debug::parse_command(line->value());
            if (command && std::holds_alternative<debug::Quit>(*command)) return {};
            const Result<debug::Answer> answer = command ? execute(*command) : tl::unexpected<Error>(command.error());
            const Result<void> told = input_ ? tell_answer(answer) : Result<void>{};
            if (auto all = comm::outcome_of_first(comm_, told); !all) return all;
            if (!input_) static_cast<void>(interrupt::forget_request());
        }
    }

  private:
    // The same on all processes; nothing at the end.
    Result<std::optional<std::string>> next_line() {
        Result<std::optional<std::string>> mine = std::nullopt;
        if (input_) mine = input_->next(fmt::format("tick {}> ", timeline_.tick()));
        if (auto all = comm::outcome_of_first(comm_, mine.map([](const auto&) {})); !all) return tl::unexpected<Error>(all.error());
        ByteWriter out;
        if (input_) {
            out.write(mine->has_value());
            // Enter repeats a step.
            out.write_string(!*mine ? "" : (*mine)->empty() ? "step" : **mine);
        }
        const auto all = comm_.allgather_any(out.view());
        ByteReader in(all[0], "a command");
        if (!in.read<bool>()) return std::nullopt;
        return in.read_string();
    }

    Result<debug::Answer> execute(const debug::Command& command) {
        const OnTheWay watched(timeline_, input_ && !options_.quiet, options_.ticks);
        return session_.execute(command);
    }

    // Errors: the session ends.
    Result<void> tell_answer(const Result<debug::Answer>& answer) {
        const auto* moved = answer ? std::get_if<debug::Moved>(&*answer) : nullptr;
        const bool interrupted = interrupt::received() != 0 || (moved != nullptr && moved->ended == sim::Ending::Interrupted);
        const bool goes_on = input_->is_terminal() && (interrupt::received() == 0 || interrupt::forget_request());
        if (answer)
            if (auto printed = print(stdout, options_.json ? debug::to_json(*answer) : visible(debug::to_text(*answer))); !printed)
                return printed;
        if (interrupted && !goes_on) return fail(fmt::format("interrupted after tick {}", timeline_.tick()), "", ExitCode::Interrupted);
        if (answer) return {};
        const Error& error = answer.error();
        if (options_.json)
            if (auto printed = print(stdout, debug::to_json(error)); !printed) return printed;
        if (!goes_on) return fail(input_->place() + error.problem, error.suggestion, error.code);
        // At a terminal it stands among the answers: what goes through mpirun by two ways comes in any order.
        return options_.json ? Result<void>{} : print(stdout, visible(error.message()) + "\n");
    }

    const RunOptions& options_;
    comm::Communicator& comm_;
    timeline::Timeline& timeline_;
    std::optional<debug::Input> input_;  // On process 0.
    debug::Session session_;
};

// Options that say what is run, beside something that says so itself.
Result<void> carries_its_own(const RunOptions& options, const std::string& what, bool code) {
    const auto given = [&]() -> const char* {
        if (!options.world.empty()) return "--world";
        if (!options.library_paths.empty()) return "--library";
        if (options.seed >= 0) return "--seed";
        if (!options.set.empty()) return "--set";
        if (!options.given.empty()) return "--arg";
        if (options.optimisation) return "-O";
        if (options.strict) return "--strict";
        if (code && !options.link.empty()) return "--link";
        if (code && !options.extensions.empty()) return "--extension";
        return nullptr;
    }();
    if (given == nullptr) return {};
    return fail(fmt::format("{} has no place here: {} says itself what was run", given, what), fmt::format("Leave out {}", given));
}

enum class Target { Program, Recording, Checkpoints };

Target target_of(const std::string& path) {
    std::error_code error;
    if (fs::is_directory(path, error)) return Target::Checkpoints;
    const Result<compare::Kind> kind = compare::kind_of(path);
    return kind && *kind == compare::Kind::Recording ? Target::Recording : Target::Program;
}

Result<RunOptions> from_recording(const RunOptions& options, const std::string& scratch, Scratch& own) {
    if (auto fits = carries_its_own(options, options.program, false); !fits) return tl::unexpected<Error>(fits.error());
    ReplayOptions replay{
        .recording = options.program, .link = options.link, .extensions = options.extensions, .run = options, .scratch = scratch};
    if (options.ticks >= 0) replay.to = options.ticks;
    replay.run.link.clear();
    replay.run.extensions.clear();
    Result<RunOptions> run = run_again(replay, "claymeld-debug", own);
    // The second recording is for `meldsim replay`.
    if (run) run->record.clear();
    return run;
}

Result<RunOptions> from_checkpoints(const RunOptions& options, const ParseRun& parse) {
    if (auto fits = carries_its_own(options, options.program, true); !fits) return tl::unexpected<Error>(fits.error());
    std::error_code error;
    const std::string folder = fs::absolute(options.program, error).lexically_normal().string();
    const Result<sim::Manifest> manifest = sim::newest_manifest(folder);
    if (!manifest) return tl::unexpected<Error>(manifest.error());
    std::optional<RunOptions> run = parse(manifest->run.command);
    if (!run)
        return fail(fmt::format("the command of the run in {} is not one of this version of meldsim", options.program),
                    "Look at it with the version that started it", ExitCode::RecordingRefused);
    run->command = manifest->run.command;
    run->resume = folder;
    run->debug = options.debug;
    if (!run->debug->commands.empty() && run->debug->commands != "-")
        run->debug->commands = fs::absolute(run->debug->commands, error).string();
    run->processes = options.processes;
    run->threads = options.threads;
    if (options.ticks >= 0) run->ticks = options.ticks;
    run->json = options.json;
    run->quiet = options.quiet;
    run->module = options.module;
    // Those that are started get the same words, from another folder.
    run->arguments = {"meldsim", "debug", folder};
    run->arguments.insert(run->arguments.end(), {"--processes", std::to_string(run->processes), "--threads", std::to_string(run->threads)});
    run->arguments.insert(run->arguments.end(), {"--history", run->debug->history});
    if (options.ticks >= 0) run->arguments.insert(run->arguments.end(), {"--ticks", std::to_string(options.ticks)});
    if (!run->debug->commands.empty()) run->arguments.insert(run->arguments.end(), {"--commands", run->debug->commands});
    if (run->json) run->arguments.emplace_back("--json");
    if (run->quiet) run->arguments.emplace_back("--quiet");
    if (run->debug->typed) run->arguments.emplace_back("--typed");
    if (run->debug->shown) run->arguments.emplace_back("--shown");
    // Paths in the command are as of then.
    fs::current_path(manifest->run.folder, error);
    if (error)
        return fail(fmt::format("the run in {} was started in the folder {}, which cannot be entered: {}", options.program,
                                manifest->run.folder, error.message()),
                    "", ExitCode::RecordingRefused);
    run->checkpoint.clear();
    run->facts_out.clear();
    return std::move(*run);
}

}  // namespace

int debug_command(RunOptions options, std::string scratch, const ParseRun& parse) {
    if (const auto bytes = parse_bytes(options.debug->history); !bytes) return tell({"--history: " + bytes.error().problem});
    // The processes that are started here have pipes.
    const auto note = [&](bool& flag, bool is, const char* word) {
        if (!is || flag) return;
        flag = true;
        options.arguments.emplace_back(word);
    };
    const bool from_input = options.debug->commands.empty() || options.debug->commands == "-";
    note(options.debug->typed, from_input && ::isatty(STDIN_FILENO) != 0, "--typed");
    note(options.debug->shown, ::isatty(STDOUT_FILENO) != 0, "--shown");
    switch (target_of(options.program)) {
        case Target::Program:
            return run_command(std::move(options));
        case Target::Checkpoints: {
            Result<RunOptions> run = from_checkpoints(options, parse);
            return run ? run_command(std::move(*run)) : tell(run.error());
        }
        case Target::Recording: {
            Scratch own;
            Result<RunOptions> run = from_recording(options, scratch, own);
            return run ? run_command(std::move(*run)) : tell(run.error());
        }
    }
    return 0;
}

Result<int> debug_run(const RunOptions& options, const Inputs& inputs, const std::vector<Claim>& claims, comm::Communicator& comm) {
    // What is done is ended between two ticks, and the session by whoever reads its commands.
    const interrupt::Answering patiently(interrupt::Answer::Patiently);
    MakeModule check;
    if (!options.replay.empty()) {
        Result<MakeModule> made = make_check(options.replay);
        if (const auto all = comm::outcome_of_all(comm, made.map([](const auto&) {})); !all) return tl::unexpected<Error>(all.error());
        check = std::move(*made);
    }
    const Result<std::unique_ptr<sim::OpenCheckpoint>> beginning = open_beginning(options, claims, inputs.world, comm);
    if (const auto all = comm::outcome_of_all(comm, beginning.map([](const auto&) {})); !all) return tl::unexpected<Error>(all.error());
    std::optional<debug::Input> input;
    if (comm.process() == 0) {
        Result<debug::Input> opened = debug::Input::open(options.debug->commands, options.debug->typed);
        if (const auto all = comm::outcome_of_first(comm, opened.map([](const auto&) {})); !all) return tl::unexpected<Error>(all.error());
        input = std::move(*opened);
    } else if (const auto all = comm::outcome_of_first(comm, {}); !all) {
        return tl::unexpected<Error>(all.error());
    }

    const auto make = [&] {
        auto simulation = std::make_unique<sim::Simulation>(inputs.info(), inputs.world, inputs.target, comm, options.threads);
        if (check) simulation->add(check(), "check");
        for (const std::string& name : writing_modules(options)) simulation->add(std::make_unique<Silent>(), name);
        return simulation;
    };
    const timeline::TimelineOptions how{.limits = {options.ticks, options.strict},
                                        .history_bytes = parse_bytes(options.debug->history).value_or(0)};
    timeline::Timeline timeline(make, inputs.registry, how);
    const sim::OpenCheckpoint* const from = beginning->get();
    if (auto done = timeline.start(from != nullptr ? &from->shares : nullptr); !done) return tl::unexpected<Error>(done.error());
    if (from != nullptr && timeline.digest(timeline.tick())->to_string() != from->checkpoint.manifest.digest)
        return fail(
            fmt::format("the checkpoint of tick {} in {} does not give back its state", from->checkpoint.manifest.tick, options.resume),
            "Please report this with the program and the world", ExitCode::OurBug);
    Conversation conversation(options, comm, timeline, std::move(input));
    const Result<void> held = conversation.hold();
    if (!held) return tl::unexpected<Error>(held.error());
    return static_cast<int>(ExitCode::Fine);
}

}  // namespace meld::driver
