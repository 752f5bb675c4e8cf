#include "runtime/driver/run/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "runtime/base/files/input_file.h"
#include "runtime/base/files/standard_streams.h"
#include "runtime/base/hash.h"
#include "runtime/base/terminal/progress.h"
#include "runtime/base/version.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/driver/run/run.h"
#include "runtime/driver/setup/outputs.h"
#include "runtime/driver/setup/print_error.h"
#include "runtime/driver/setup/scratch_folder.h"
#include "runtime/results/compare/compare.h"
#include "runtime/results/record/recording.h"
#include "runtime/results/record/recording_reader.h"
#include "runtime/results/record/state_digest.h"
#include "runtime/world/description/limits.h"
#include "runtime/world/file/world_file.h"

namespace meld::driver {

namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMaxFile_bytes = std::uint64_t{4} << 30;

Result<std::uint64_t> hash_of(const std::string& path) {
    return read_input(path, kMaxFile_bytes).map([](const std::string& text) { return hash_text(text); });
}

Result<std::vector<record::CodeFile>> code_files(const std::vector<std::string>& paths) {
    std::vector<record::CodeFile> files;
    for (const std::string& path : paths) {
        const Result<std::uint64_t> hash = hash_of(path);
        if (!hash) return tl::unexpected<Error>(hash.error());
        std::error_code error;
        files.push_back({fs::absolute(path, error).string(), *hash});
    }
    return files;
}

// A folder, from that of the program's file.
std::string from_program(const std::string& folder, const std::string& program) {
    std::error_code error;
    const fs::path base = fs::absolute(program, error).lexically_normal().parent_path();
    return fs::absolute(folder, error).lexically_normal().lexically_relative(base).string();
}

// A module that was compiled beforehand does not tell by which folders its includes were found: those that they are in, and the ones above
// these, as far as they are named.
std::vector<std::string> folders_of(const std::vector<record::Provenance::Source>& sources) {
    std::vector<std::string> found;
    for (const auto& source : sources) {
        fs::path folder = fs::path(source.path).lexically_normal();
        do {
            folder = folder.parent_path();
            const std::string name = folder.empty() ? "." : folder.string();
            if (std::ranges::find(found, name) == found.end()) found.push_back(name);
        } while (!folder.empty() && folder.filename() != "..");
    }
    return found;
}

// What the recording says of its run. Errors: it says nothing, or is of another version.
Result<record::Provenance> read_provenance(const record::RecordingReader& recording) {
    const std::string text = recording.about("provenance");
    if (text.empty())
        return fail(recording.path() + " does not say how its run is made again", "Record it with this version of meldsim",
                    ExitCode::RecordingRefused);
    Result<record::Provenance> p = record::provenance_from_json(text);
    if (!p) return fail(fmt::format("{}: {}", recording.path(), p.error().problem), p.error().suggestion, p.error().code);
    if (p->version != kVersion)
        return fail(fmt::format("{} is of version {}, and this is {}", recording.path(), p->version, kVersion),
                    "Replay it by the version that made it", ExitCode::RecordingRefused);
    if (!p->forked_from.empty())
        return fail(fmt::format("{} is of a run that branched off from a checkpoint in {}, which it does not carry", recording.path(),
                                p->forked_from),
                    "Branch off there again by `meldsim fork`, if the checkpoint is still there", ExitCode::RecordingRefused);
    return p;
}

// Where the code is now: a file that was given with the same content, or else the one that the run had.
Result<std::vector<std::string>> find_code(const std::vector<record::CodeFile>& wanted, const std::vector<std::string>& given,
                                           const char* option) {
    std::vector<std::string> paths;
    for (const record::CodeFile& file : wanted) {
        std::vector<std::string> candidates = given;
        candidates.push_back(file.path);
        const auto found = std::ranges::find_if(candidates, [&](const std::string& path) {
            const Result<std::uint64_t> hash = hash_of(path);
            return hash && *hash == file.hash;
        });
        if (found == candidates.end())
            return fail(fmt::format("the run was made with {}, and neither there nor among the files given is one with its hash, {:016x}",
                                    file.path, file.hash),
                        fmt::format("Give the file that it was with {}", option));
        paths.push_back(*found);
    }
    return paths;
}

// A place for a file of the program below this folder, whatever the recording says. Errors: it leads elsewhere.
Result<fs::path> place_in(const fs::path& folder, const fs::path& program_folder, const std::string& path) {
    const fs::path place = (program_folder / path).lexically_normal();
    const fs::path inside = place.lexically_relative(folder);
    if (fs::path(path).is_absolute() || inside.empty() || *inside.begin() == "..")
        return fail(fmt::format("the program's file '{}' cannot be placed", path), "", ExitCode::RecordingRefused);
    return place;
}

// The folder of the program's own file: so deep that no other of its files is above `folder`.
fs::path program_folder(const fs::path& folder, const record::Provenance& p) {
    std::ptrdiff_t most = 0;
    const auto note = [&](const std::string& path) {
        const fs::path normal = fs::path(path).lexically_normal();
        most = std::max(most, std::count(normal.begin(), normal.end(), fs::path("..")));
    };
    for (const auto& source : p.program) note(source.path);
    for (const std::string& library : p.libraries) note(library);
    fs::path out = folder / "program";
    for (std::ptrdiff_t i = 0; i < most; ++i) out /= "in";
    return out;
}

Result<void> write_program(Scratch& scratch, const record::Provenance& p) {
    for (const auto& source : p.program) {
        const Result<fs::path> place = place_in(scratch.path(), program_folder(scratch.path(), p), source.path);
        if (!place) return tl::unexpected<Error>(place.error());
        if (auto written = scratch.write(*place, source.text); !written) return written;
    }
    return {};
}

// What is compared with a run: its program, and its digests by tick.
struct Recorded {
    record::Provenance provenance;
    std::map<std::int64_t, Digest> digests;
};

class Check : public sim::SimModule {
  public:
    explicit Check(std::shared_ptr<const Recorded> recorded) : recorded_(std::move(recorded)) {}
    Result<void> saveable() const override { return {}; }
    Result<void> start(sim::Subdomain& subdomain) override {
        // A run without a tick, too, tells it at its end.
        const Result<void> same = same_program(subdomain.module);
        if (same) ending_ = compare(subdomain);
        return same;
    }
    // The state comes later, and was compared when it was there first.
    Result<void> resume(sim::Subdomain& subdomain) override { return same_program(subdomain.module); }
    Result<void> after(sim::Subdomain& subdomain) override {
        if (ending_) ending_ = compare(subdomain);
        return ending_;
    }
    Result<void> ending() const override { return ending_; }

  private:
    Result<void> same_program(const ModuleInfo& module) const {
        const auto& program = recorded_->provenance.program;
        bool same = module.source_count == program.size() && module.program_count == recorded_->provenance.programs;
        for (u32 i = 0; same && i < module.source_count; ++i) same = module.sources[i].text == program[i].text;
        if (!same)
            return fail("the program includes other files than it did",
                        "Include files by paths from the program's own folder, or by -I, before recording", ExitCode::RecordingRefused);
        return {};
    }
    Result<void> compare(sim::Subdomain& subdomain) const {
        const auto recorded = recorded_->digests.find(subdomain.tick());
        if (recorded == recorded_->digests.end() || record::state_digest(subdomain) == recorded->second) return {};
        return fail(fmt::format("tick {} is not as it was recorded", subdomain.tick()), "`meldsim replay` tells what differs",
                    ExitCode::PropertyFailed);
    }

    std::shared_ptr<const Recorded> recorded_;
    Result<void> ending_;
};

// What differs, in a sentence.
Error difference(const RunOptions& options, const compare::Report& report, const Result<void>& ran) {
    std::string where = report.tick ? fmt::format("tick {} is not as it was recorded", *report.tick)
                        : ran       ? "the run is not as it was recorded"
                                    : ran.error().problem;
    if (report.catom) where += fmt::format(": catom @{}", *report.catom);
    if ((report.tick || !ran) && !report.catom) where += "; what differs is not recorded";
    for (const auto* part : {&report.runs, &report.here})
        for (const compare::Difference& each : *part)
            where += fmt::format("; {}: {} now, {} in {}", each.what, each.b.empty() ? "none" : fmt::format("{}", fmt::join(each.b, ", ")),
                                 each.a.empty() ? "none" : fmt::format("{}", fmt::join(each.a, ", ")), options.replay);
    return {where, "", ExitCode::PropertyFailed};
}

std::string outcome_json(const RunOptions& options, const compare::Report& report, bool same, std::int64_t tick) {
    nlohmann::ordered_json json = {{"recording", options.replay}, {"same", same}, {"ticks", tick}, {"steps", report.same_ticks}};
    if (!same) {
        json["tick"] = report.tick.value_or(tick);
        if (report.catom) json["catom"] = *report.catom;
        nlohmann::ordered_json differences = nlohmann::ordered_json::array();
        for (const auto* part : {&report.runs, &report.here})
            for (const compare::Difference& each : *part)
                differences.push_back({{"what", each.what}, {"recorded", each.a}, {"now", each.b}});
        json["differences"] = std::move(differences);
    }
    return json.dump(2, ' ', true, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

// On the first process.
Result<int> compare_and_print(const RunOptions& options, const Result<void>& ran, std::int64_t tick) {
    Result<compare::Report> report = [&] {
        Progress progress(options.quiet ? ProgressOutput::nowhere() : ProgressOutput::on_stderr());
        return compare::compare_recordings(options.replay, options.record, progress);
    }();
    if (!report) return tl::unexpected<Error>(report.error());
    // Steps that only one of them has are not compared, so the one that is made now must not end before the other.
    if (ran && tick < options.ticks)
        report->runs.push_back({"the last tick", {fmt::format("at least {}", options.ticks)}, {std::to_string(tick)}});
    const bool same = ran && !report->tick && report->runs.empty();
    Result<void> printed;
    if (options.json)
        printed = print(stdout, outcome_json(options, *report, same, tick));
    else if (!same)
        return tl::unexpected<Error>(difference(options, *report, ran));
    else if (!options.quiet)
        printed = print(results_at_standard_output(options) ? stderr : stdout,
                        fmt::format("replayed {} tick{}: {} the same\n", tick, tick == 1 ? "" : "s",
                                    report->same_ticks == 1 ? "the only recorded step is"
                                                            : fmt::format("all {} recorded steps are", report->same_ticks)));
    if (!printed) return tl::unexpected<Error>(printed.error());
    return static_cast<int>(same ? ExitCode::Fine : ExitCode::PropertyFailed);
}

// What the run is made again from.
struct Again {
    record::Provenance from;
    std::int64_t last = 0;  // Tick.
    std::vector<std::string> link, extensions;
};

Result<Again> read_again(const ReplayOptions& options) {
    const Result<record::RecordingReader> recording = record::RecordingReader::open(options.recording);
    if (!recording) return tl::unexpected<Error>(recording.error());
    Result<record::Provenance> p = read_provenance(*recording);
    if (!p) return tl::unexpected<Error>(p.error());
    if (recording->ticks().empty()) return fail(options.recording + " has no step", "", ExitCode::RecordingRefused);
    const std::int64_t last = recording->ticks().back();
    if (options.to && *options.to > last)
        return fail(fmt::format("{} ends with tick {}, before tick {}", options.recording, last, *options.to));
    // Nobody knows what was linked into a module that was compiled beforehand; the digests tell whether it is the same.
    const auto linked = p->linked.empty() ? options.link : find_code(p->linked, options.link, "--link");
    if (!linked) return tl::unexpected<Error>(linked.error());
    const auto extensions = find_code(p->extensions, options.extensions, "--extension");
    if (!extensions) return tl::unexpected<Error>(extensions.error());
    return Again{std::move(*p), options.to.value_or(last), *linked, *extensions};
}

// The options of the run that is made again, in the folder `scratch`.
RunOptions options_of(const ReplayOptions& options, const Again& again, const fs::path& scratch) {
    RunOptions run = options.run;
    const fs::path folder = program_folder(scratch, again.from);
    for (const std::string& library : again.from.libraries) run.library_paths.push_back((folder / library).lexically_normal().string());
    run.program = (folder / again.from.program.front().path).string();
    for (std::uint32_t i = 1; i < again.from.programs; ++i) run.programs.push_back((folder / again.from.program[i].path).string());
    run.link = again.link;
    run.extensions = again.extensions;
    run.optimisation = again.from.optimisation;
    run.strict = again.from.strict;
    run.ticks = again.last;
    run.replay = options.recording;
    run.record = (scratch / "again.vtkhdf").string();
    return run;
}

}  // namespace

Result<RunOptions> run_again(const ReplayOptions& options, std::string_view name, Scratch& own) {
    const Result<Again> again = read_again(options);
    if (!again) return tl::unexpected<Error>(again.error());
    if (!options.scratch.empty()) return options_of(options, *again, options.scratch);
    if (const auto made = own.make(name); !made) return tl::unexpected<Error>(made.error());
    if (const auto written = write_program(own, again->from); !written) return tl::unexpected<Error>(written.error());
    RunOptions run = options_of(options, *again, own.path());
    for (const char* suffix : {"", record::kSidecar, record::kLinesSidecar}) own.expect(run.record + suffix);
    run.arguments.insert(run.arguments.end(), {"--scratch", own.path().string()});
    return run;
}

int replay_command(const ReplayOptions& options) {
    Scratch own;
    Result<RunOptions> run = run_again(options, "claymeld-replay", own);
    return run ? run_command(std::move(*run)) : print_error(run.error());
}

Result<record::Provenance> provenance(const RunOptions& options, const ModuleInfo& module, const world::World& world) {
    record::Provenance p{.version = std::string(kVersion),
                         .forked_from = options.fork,
                         .program = {},
                         .programs = module.program_count,
                         .libraries = {},
                         .optimisation = options.optimisation,
                         .linked = {},
                         .extensions = {},
                         .world_path = world.path,
                         .world = world.text,
                         .world_files = {},
                         .set = world.set,
                         .limits = options.limits,
                         .seed = world.seed,
                         .ports = std::string(world.ports_name()),
                         .strict = options.strict};
    for (u32 i = 0; i < module.source_count; ++i) p.program.push_back({module.sources[i].path, module.sources[i].text});
    if (options.program.ends_with(".so"))
        p.libraries = folders_of(p.program);
    else
        for (const std::string& folder : options.library_paths) p.libraries.push_back(from_program(folder, options.program));
    for (auto [paths, files] : {std::pair{&options.link, &p.linked}, std::pair{&options.extensions, &p.extensions}}) {
        Result<std::vector<record::CodeFile>> code = code_files(*paths);
        if (!code) return tl::unexpected<Error>(code.error());
        *files = std::move(*code);
    }
    std::uint64_t hash = hash_text(world.text);
    for (const std::string& path : world.files) {
        Result<std::string> text = read_input(path, kMaxFile_bytes);
        if (!text) return tl::unexpected<Error>(text.error());
        hash = hash_combine(hash, hash_text(*text));
        p.world_files[path] = std::move(*text);
    }
    if (hash != world.source_hash) return fail("a file that the world names has changed while the run was set up", "Start it again");
    return p;
}

Result<world::World> recorded_world(const std::string& path) {
    const Result<record::RecordingReader> recording = record::RecordingReader::open(path);
    if (!recording) return tl::unexpected<Error>(recording.error());
    const Result<record::Provenance> p = read_provenance(*recording);
    if (!p) return tl::unexpected<Error>(p.error());
    Result<world::World> world = world::parse_world(p->world, p->world_path, &p->world_files);
    if (!world) return world;
    if (const auto done = world::set_seed(*world, p->seed); !done) return tl::unexpected<Error>(done.error());
    for (const std::string& limit : p->limits)
        if (const auto done = world::set_limit(*world, limit); !done) return tl::unexpected<Error>(done.error());
    if (const auto done = world::set_ports(*world, p->ports); !done) return tl::unexpected<Error>(done.error());
    world->set = p->set;
    return world;
}

Result<MakeModule> make_check(const std::string& path) {
    const Result<record::RecordingReader> recording = record::RecordingReader::open(path);
    if (!recording) return tl::unexpected<Error>(recording.error());
    Result<record::Provenance> p = read_provenance(*recording);
    if (!p) return tl::unexpected<Error>(p.error());
    const Result<std::vector<Digest>> digests = recording->digests();
    if (!digests) return tl::unexpected<Error>(digests.error());
    auto recorded = std::make_shared<Recorded>(Recorded{std::move(*p), {}});
    for (std::size_t i = 0; i < digests->size(); ++i) recorded->digests[recording->ticks()[i]] = (*digests)[i];
    return [recorded = std::shared_ptr<const Recorded>(std::move(recorded))] { return std::make_unique<Check>(recorded); };
}

Result<int> end_replay(const RunOptions& options, const Result<void>& ran, std::int64_t tick, bool interrupted, comm::Communicator& comm) {
    if (!ran && ran.error().code != ExitCode::PropertyFailed) return tl::unexpected<Error>(ran.error());
    if (interrupted) return fail(fmt::format("interrupted after tick {}", tick), "", ExitCode::Interrupted);
    const Result<int> mine = comm.process() == 0 ? compare_and_print(options, ran, tick) : Result<int>(0);
    const Result<void> alike = comm::outcome_of_first(comm, mine.map([](int) {}));
    if (!alike) return tl::unexpected<Error>(alike.error());
    return comm::value_of_first(comm, *mine);
}

}  // namespace meld::driver
