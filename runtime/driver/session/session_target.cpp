#include "runtime/driver/session/session_target.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "runtime/driver/pictures/picture_options.h"
#include "runtime/driver/run/replay.h"
#include "runtime/driver/run/replay_without_outputs.h"
#include "runtime/driver/session/view.h"
#include "runtime/results/compare/compare.h"
#include "runtime/sim/state/checkpoint_folder.h"

namespace meld::driver {

namespace {

namespace fs = std::filesystem;

enum class Target { Program, Recording, Checkpoints };

Target target_of(const std::string& path) {
    std::error_code error;
    if (fs::is_directory(path, error)) return Target::Checkpoints;
    const Result<compare::Kind> kind = compare::kind_of(path);
    if (kind) return *kind == compare::Kind::Recording ? Target::Recording : Target::Program;
    // A damaged recording is none that can be compared, and no program either.
    return compare::begins_as_hdf5(path) ? Target::Recording : Target::Program;
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
    run->question = options.question;
    if (!run->debug->commands.empty() && run->debug->commands != "-")
        run->debug->commands = fs::absolute(run->debug->commands, error).string();
    run->processes = options.processes;
    run->threads = options.threads;
    if (options.ticks >= 0) run->ticks = options.ticks;
    run->json = options.json;
    run->quiet = options.quiet;
    run->module = options.module;
    // Those that are started get the same words, from another folder.
    const std::optional<Inquiry>& inquiry = run->debug->inquiry;
    // What the run was limited to is no limit of what may be asked.
    if (inquiry && run->ticks >= 0) run->ticks = std::max(run->ticks, inquiry->tick);
    if (run->debug->view && run->ticks >= 0) run->ticks = std::max(run->ticks, run->debug->view->tick);
    std::optional<PictureOptions>& picture = run->debug->picture;
    if (picture && run->ticks >= 0) run->ticks = std::max(run->ticks, last_tick_of(*picture).value_or(-1));
    // And the picture stands where it was asked for.
    if (picture && picture->file != "-") {
        const std::string file = fs::absolute(picture->file, error).string();
        std::ranges::replace(run->debug->inquiry->flags, picture->file, file);
        picture->file = file;
    }
    const std::optional<ViewOptions>& view = run->debug->view;
    run->arguments = {"meldsim", inquiry ? inquiry->command : view ? "view" : "debug", folder};
    if (view) {
        const std::vector<std::string> flags = view_arguments(*view);
        run->arguments.insert(run->arguments.end(), flags.begin(), flags.end());
    }
    if (inquiry) {
        run->arguments.insert(run->arguments.end(), inquiry->words.begin(), inquiry->words.end());
        run->arguments.insert(run->arguments.end(), inquiry->flags.begin(), inquiry->flags.end());
        if (inquiry->tick >= 0) run->arguments.insert(run->arguments.end(), {"--tick", std::to_string(inquiry->tick)});
        if (inquiry->limit) run->arguments.insert(run->arguments.end(), {"--limit", std::to_string(*inquiry->limit)});
        if (inquiry->csv) run->arguments.emplace_back("--csv");
        if (inquiry->dot) run->arguments.emplace_back("--dot");
    }
    run->arguments.insert(run->arguments.end(), {"--processes", std::to_string(run->processes), "--threads", std::to_string(run->threads)});
    if (!inquiry) run->arguments.insert(run->arguments.end(), {"--history", run->debug->history});
    if (!inquiry) run->arguments.insert(run->arguments.end(), {"--folder", run->debug->folder});
    if (options.ticks >= 0) run->arguments.insert(run->arguments.end(), {"--ticks", std::to_string(options.ticks)});
    if (!run->debug->commands.empty()) run->arguments.insert(run->arguments.end(), {"--commands", run->debug->commands});
    if (run->json) run->arguments.emplace_back("--json");
    if (run->quiet) run->arguments.emplace_back("--quiet");
    if (run->debug->typed) run->arguments.emplace_back("--typed");
    if (run->debug->shown) run->arguments.emplace_back("--shown");
    if (run->debug->served) run->arguments.emplace_back("--served");
    // Paths in the command are as of then.
    fs::current_path(manifest->run.folder, error);
    if (error)
        return fail(fmt::format("the run in {} was started in the folder {}, which cannot be entered: {}", options.program,
                                manifest->run.folder, error.message()),
                    "", ExitCode::RecordingRefused);
    run->debug->writers = writing_modules(*run);
    // The module is the same, with its counters or its places.
    run->places = run->measured();
    run->checkpoint.clear();
    for (const OutputOption& output : kOutputs) (*run.*output.path).clear();
    for (const BodiesOption& watch : kWatches) (*run.*watch.bodies).clear();
    run->timeout_seconds = 0;
    return std::move(*run);
}

}  // namespace

Result<void> carries_its_own(const RunOptions& options, const std::string& what, bool code) {
    const auto given = [&]() -> const char* {
        if (!options.world.empty()) return "--world";
        if (!options.events.empty()) return "--events";
        if (!options.library_paths.empty()) return "--library";
        if (options.seed >= 0) return "--seed";
        if (!options.ports.empty()) return "--ports";
        if (!options.set.empty()) return "--set";
        if (!options.limits.empty()) return "--limit";
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

Result<RunOptions> looked_at(RunOptions options, const std::string& scratch, Scratch& own, const ParseRun& parse) {
    switch (target_of(options.program)) {
        case Target::Program:
            return options;
        case Target::Recording:
            return from_recording(options, scratch, own);
        case Target::Checkpoints:
            return from_checkpoints(options, parse);
    }
    return options;
}

Result<RunOptions> looked_at_beside(const RunOptions& options, Scratch& own) {
    const std::string& path = options.debug->view->other;
    if (options.processes > 1) return fail("two runs are shown beside each other on one process", "Leave out -n");
    if (target_of(path) == Target::Checkpoints)
        return fail(fmt::format("{} is a folder of checkpoints, which is not shown beside another run", path), "Show it first, or alone");
    std::error_code error;
    // Another folder may be entered for the first.
    RunOptions other{.program = fs::absolute(path, error).lexically_normal().string(), .ticks = options.ticks, .threads = options.threads};
    other.debug = options.debug;
    other.quiet = options.quiet;
    if (target_of(path) == Target::Program) return other;
    return from_recording(other, "", own);
}

}  // namespace meld::driver
