#include "runtime/driver/run/fork.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <utility>

#include "runtime/base/files/output_file.h"
#include "runtime/base/files/output_paths.h"
#include "runtime/base/terminal/log.h"
#include "runtime/driver/run/run.h"
#include "runtime/driver/run/run_configuration.h"
#include "runtime/driver/setup/command_line.h"
#include "runtime/driver/setup/inputs.h"
#include "runtime/driver/setup/print_error.h"
#include "runtime/driver/setup/watch_options.h"
#include "runtime/results/record/state_digest.h"

namespace meld::driver {

namespace {

namespace fs = std::filesystem;

// ---- the command

// Paths that were typed in one folder, as of another one. What lies in that is named from there, as the run's own files are: a module
// contains the paths of its sources.
class Paths {
  public:
    Paths(fs::path from, fs::path to) : from_(std::move(from)), to_(std::move(to)) {}
    std::string operator()(const std::string& path) const {
        if (path.empty() || is_standard_output(path) || OutputFile::names_stream(path)) return path;
        const fs::path whole = (from_ / path).lexically_normal();
        const fs::path inside = whole.lexically_relative(to_);
        return inside.empty() || *inside.begin() == ".." ? whole.string() : inside.string();
    }
    std::vector<std::string> operator()(std::vector<std::string> paths) const {
        for (std::string& path : paths) path = (*this)(path);
        return paths;
    }

  private:
    fs::path from_, to_;
};

template <class T>
T first_given(T given, T before) {
    return given.empty() ? std::move(before) : std::move(given);
}

// The run of a checkpoint with what is given anew. How far it goes and where its results go is its own affair.
RunOptions merge(RunOptions before, const RunOptions& given, const Paths& here) {
    RunOptions out = given;
    // A program has its own world only if nobody says which; this one has that of the checkpoint.
    out.world = first_given(here(given.world), world_path(before));
    out.program = first_given(here(given.program), before.program);
    out.library_paths = first_given(here(given.library_paths), before.library_paths);
    out.link = first_given(here(given.link), before.link);
    out.extensions = first_given(here(given.extensions), before.extensions);
    out.events = first_given(here(given.events), before.events);
    // Of a constant that is set twice, the later value counts.
    out.set = std::move(before.set);
    out.set.insert(out.set.end(), given.set.begin(), given.set.end());
    out.limits = std::move(before.limits);
    out.limits.insert(out.limits.end(), given.limits.begin(), given.limits.end());
    out.given = std::move(before.given);
    for (std::size_t i = 0; i < given.given.size(); ++i) {
        if (i < out.given.size())
            out.given[i] = given.given[i];
        else
            out.given.push_back(given.given[i]);
    }
    if (!given.optimisation) out.optimisation = before.optimisation;
    if (given.seed < 0) out.seed = before.seed;
    out.ports = first_given(given.ports, before.ports);
    out.strict = given.strict || before.strict;
    for (const OutputOption& output : kOutputs) out.*output.path = here(given.*output.path);
    out.checkpoint = here(given.checkpoint);
    for (std::string& text : out.watch)
        if (names_watch_file(text)) text = here(text);
    return out;
}

// The results of the run of the checkpoint stay as they are.
Result<void> check_writes_elsewhere(const RunOptions& fork, const RunOptions& before, const std::string& folder) {
    std::vector<NamedPath> paths;
    const auto add = [&](const char* option, const std::string& path, NamedPath::Use use) {
        if (use == NamedPath::Written)
            paths.push_back({option, path, use});
        else if (!is_standard_output(path) && !OutputFile::names_stream(path))
            paths.push_back({fmt::format("{} of the run in {}", option, folder), path, use});
    };
    for (const auto& [run, use] : {std::pair{&before, NamedPath::Read}, std::pair{&fork, NamedPath::Written}})
        for (const OutputOption& output : kOutputs) add(output.name, run->*output.path, use);
    return check_distinct(paths);
}

// ---- in its processes

// The parts of a world that say what may happen from now on, and not what has happened.
const std::set<std::string, std::less<>> kMayChange = {"event", "limits", "record", "seed", "set", "target"};

std::string part_name(const std::string& part) {
    if (part == "files") return "a file that the world names";
    if (part == "event" || part == "body" || part == "assembly") return fmt::format("[[{}]] of the world", part);
    const bool key = part == "lattice" || part == "radius" || part == "held" || part == "seed" || part == "ports";
    return key ? part + " of the world" : fmt::format("[{}] of the world", part);
}

std::set<std::string> parts_that_differ(const std::map<std::string, std::uint64_t>& was, const std::map<std::string, std::uint64_t>& is) {
    std::set<std::string> out;
    for (const auto& [one, other] : {std::pair{&was, &is}, std::pair{&is, &was}})
        for (const auto& [part, hash] : *one)
            if (const auto found = other->find(part); found == other->end() || found->second != hash) out.insert(part);
    return out;
}

tl::unexpected<Error> cannot(const std::string& folder, const std::string& why, const std::string& cure) {
    return fail(fmt::format("no run can branch off from the checkpoint in {}: {}", folder, why), cure, ExitCode::RecordingRefused);
}

// What is not as it was, if all of it may be so.
Result<void> compare(const sim::RunIdentity& was, const sim::RunIdentity& is, Forked& out) {
    if (was.traits.size() != is.traits.size()) return cannot(out.folder, "it was made by another version of Claymeld", "");
    for (std::size_t i = 0; i < was.traits.size(); ++i) {
        const sim::Trait &before = was.traits[i], &now = is.traits[i];
        if (before.name != now.name) return cannot(out.folder, "it was made by another version of Claymeld", "");
        if (before.hash == now.hash || before.name == "the world") continue;
        if (before.name == "the version of Claymeld")
            return cannot(out.folder, fmt::format("it was made by version {}, and this is {}", before.shown, now.shown),
                          "Go on with that version, or start a new run");
        if (before.name == kPortsClaim)
            return cannot(out.folder, fmt::format("the ports had the numbers of '{}', and now those of '{}'", before.shown, now.shown),
                          "Give the same --ports, or none");
        if (before.name == "--extension")
            return cannot(out.folder, "the extensions are not those that it was started with, and only they can read what they have kept",
                          "Give the same ones, with the same content");
        if (before.name == "the module" || before.name == "the parameters") out.anew = true;
        // The file of the program comes before its module, which differs with it, and with more.
        if (before.name != "the module")
            out.changed.push_back(before.name);
        else if (std::ranges::find(out.changed, "the program") == out.changed.end())
            out.changed.emplace_back("how the program is compiled, or what it includes");
    }
    for (const std::string& part : parts_that_differ(was.world, is.world)) {
        if (!kMayChange.contains(part))
            return cannot(
                out.folder, fmt::format("{} is not as it was", part_name(part)),
                "A run that branches off has the catoms as they are: only [[event]], [limits], [record], [set], [target] and seed "
                "may change. Put it back, or start a new run");
        // Constants and the seed have been compared as they are in all.
        if (part != "set" && part != "seed") out.changed.push_back(part_name(part));
    }
    return {};
}

}  // namespace

int fork_command(ForkOptions options, const ParseRun& parse) {
    std::error_code error;
    const fs::path here = fs::current_path(error);
    const std::string folder = fs::absolute(options.folder, error).lexically_normal().string();
    const Result<sim::Manifest> manifest = sim::newest_manifest(folder);
    if (!manifest) return print_error(manifest.error());
    const std::optional<RunOptions> before = parse(manifest->run.command);
    if (!before)
        return print_error({fmt::format("the command of the run in {} is not one of this version of meldsim", options.folder),
                            "Branch off by the version that started it", ExitCode::RecordingRefused});
    // Paths in the command are as of then.
    fs::current_path(manifest->run.folder, error);
    if (error)
        return print_error({fmt::format("the run in {} was started in the folder {}, which cannot be entered: {}", options.folder,
                                        manifest->run.folder, error.message()),
                            "", ExitCode::RecordingRefused});
    RunOptions merged = merge(*before, options.run, Paths(here, manifest->run.folder));
    merged.fork = folder;
    if (const auto distinct = check_writes_elsewhere(merged, *before, options.folder); !distinct) return print_error(distinct.error());
    // Read again as its processes will read it.
    const std::vector<std::string> words = command_line(merged);
    std::optional<RunOptions> run = parse(words);
    if (!run) return static_cast<int>(ExitCode::UsageOrWorld);
    run->arguments = run->command = words;
    return run_command(std::move(*run));
}

Result<Forked> branch_off(const std::string& folder, const sim::RunIdentity& now, sim::Simulation& simulation,
                          const sim::Registry& registry) {
    comm::Communicator& comm = simulation.subdomain().comm;
    const Result<sim::OpenCheckpoint> newest = sim::open_newest(folder, comm);
    if (!newest) return tl::unexpected<Error>(newest.error());
    const sim::Checkpoint& checkpoint = newest->checkpoint;
    if (!checkpoint.passed_over.empty() && comm.process() == 0)
        log::warning("a newer checkpoint is not whole, and the run branches off from that of tick {}: {}", checkpoint.manifest.tick,
                     checkpoint.passed_over);
    Forked out{.folder = folder, .tick = checkpoint.manifest.tick, .digest = checkpoint.manifest.digest, .changed = {}, .facts = {}};
    if (auto fits = compare(checkpoint.manifest.run, now, out); !fits) return tl::unexpected<Error>(fits.error());
    const bool aims_elsewhere = std::ranges::find(out.changed, part_name("target")) != out.changed.end();
    const sim::Loads how = out.anew ? sim::Loads::Anew : aims_elsewhere ? sim::Loads::LooksAgain : sim::Loads::BranchesOff;
    Result<sim::TakenOver> facts = simulation.fork(registry, newest->shares, how);
    if (!facts) return tl::unexpected<Error>(facts.error());
    out.facts = std::move(*facts);
    if (out.anew || record::state_digest(simulation.subdomain()).to_string() == out.digest) return out;
    return fail(fmt::format("the checkpoint of tick {} in {} does not give back its state", out.tick, folder),
                "Please report this with the program and the world", ExitCode::OurBug);
}

std::string describe(const Forked& forked) {
    std::string text = fmt::format("tick {} of {}", forked.tick, forked.folder);
    for (std::size_t i = 0; i < forked.changed.size(); ++i) text += (i == 0 ? "; other than there: " : ", ") + forked.changed[i];
    return text;
}

std::string describe_dropped(const Forked& forked) {
    std::string text;
    std::size_t left = forked.facts.dropped.size();
    std::uint64_t all = 0;
    for (const auto& [name, count] : forked.facts.dropped) {
        const bool first = text.empty();
        text += first ? "" : --left == 1 ? " and " : ", ";
        text += first ? fmt::format("{} fact{} of {}", count, count == 1 ? "" : "s", name) : fmt::format("{} of {}", count, name);
        all += count;
    }
    return text + (all == 1 ? " is dropped" : " are dropped");
}

}  // namespace meld::driver
