#include "runtime/driver/replay.h"

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "runtime/base/hash.h"
#include "runtime/base/input_file.h"
#include "runtime/base/output_file.h"
#include "runtime/base/progress.h"
#include "runtime/base/standard_streams.h"
#include "runtime/base/version.h"
#include "runtime/base/visible.h"
#include "runtime/comm/outcome.h"
#include "runtime/compare/compare.h"
#include "runtime/driver/outputs.h"
#include "runtime/driver/run.h"
#include "runtime/record/recording_reader.h"
#include "runtime/record/state_digest.h"

namespace meld::driver {

namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMaxFile_bytes = std::uint64_t{4} << 30;

int tell(const Error& error) {
    clear_progress();
    static_cast<void>(print(stderr, fmt::format("meldsim: {}\n", visible(error.message()))));
    return static_cast<int>(error.code);
}

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

Result<void> write_program(const fs::path& folder, const record::Provenance& p) {
    for (const auto& source : p.program) {
        const Result<fs::path> place = place_in(folder, program_folder(folder, p), source.path);
        if (!place) return tl::unexpected<Error>(place.error());
        std::error_code error;
        fs::create_directories(place->parent_path(), error);
        if (auto written = write_file(place->string(), source.text); !written) return written;
    }
    return {};
}

// Goes with what is in it.
class Scratch {
  public:
    Scratch() = default;
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;
    ~Scratch() {
        std::error_code error;
        if (!path_.empty()) fs::remove_all(path_, error);
    }
    Result<std::string> make() {
        std::error_code error;
        std::string name = (fs::temp_directory_path(error) / "claymeld-replay-XXXXXX").string();
        if (error || ::mkdtemp(name.data()) == nullptr) return fail(fmt::format("cannot make a folder {}", name));
        return path_ = name;
    }

  private:
    std::string path_;
};

class Check : public sim::SimModule {
  public:
    Check(record::Provenance provenance, std::map<std::int64_t, Digest> digests)
        : provenance_(std::move(provenance)), digests_(std::move(digests)) {}
    Result<void> saveable() const override { return {}; }
    Result<void> start(sim::Subdomain& subdomain) override {
        const ModuleInfo& module = subdomain.module;
        bool same = module.source_count == provenance_.program.size();
        for (u32 i = 0; same && i < module.source_count; ++i) same = module.sources[i].text == provenance_.program[i].text;
        if (!same)
            return fail("the program includes other files than it did",
                        "Include files by paths from the program's own folder, or by -I, before recording", ExitCode::RecordingRefused);
        // A run without a tick, too, tells it at its end.
        ending_ = compare(subdomain);
        return {};
    }
    Result<void> after(sim::Subdomain& subdomain) override {
        if (ending_) ending_ = compare(subdomain);
        return ending_;
    }
    Result<void> ending() const override { return ending_; }

  private:
    Result<void> compare(sim::Subdomain& subdomain) const {
        const auto recorded = digests_.find(subdomain.tick());
        if (recorded == digests_.end() || record::state_digest(subdomain) == recorded->second) return {};
        return fail(fmt::format("tick {} is not as it was recorded", subdomain.tick()), "", ExitCode::PropertyFailed);
    }

    record::Provenance provenance_;
    std::map<std::int64_t, Digest> digests_;
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
    std::optional<Progress> progress;
    if (!options.quiet) progress.emplace();
    std::optional<Progress> silent;
    if (!progress) silent.emplace();
    const Result<compare::Report> report = compare::compare_recordings(options.replay, options.record, progress ? *progress : *silent);
    progress.reset();
    silent.reset();
    if (!report) return tl::unexpected<Error>(report.error());
    const bool same = ran && !report->tick && report->runs.empty();
    Result<void> printed;
    if (options.json)
        printed = print(stdout, outcome_json(options, *report, same, tick));
    else if (!same)
        return tl::unexpected<Error>(difference(options, *report, ran));
    else if (!options.quiet)
        printed = print(results_at_standard_output(options) ? stderr : stdout,
                        fmt::format("replayed {} tick{}: all {} recorded step{} are the same\n", tick, tick == 1 ? "" : "s",
                                    report->same_ticks, report->same_ticks == 1 ? "" : "s"));
    if (!printed) return tl::unexpected<Error>(printed.error());
    return static_cast<int>(same ? ExitCode::Fine : ExitCode::PropertyFailed);
}

// The options of the run that is made again, in the folder `scratch`.
Result<RunOptions> run_again(const ReplayOptions& options, const std::string& scratch) {
    const Result<record::RecordingReader> recording = record::RecordingReader::open(options.recording);
    if (!recording) return tl::unexpected<Error>(recording.error());
    const Result<record::Provenance> p = read_provenance(*recording);
    if (!p) return tl::unexpected<Error>(p.error());
    if (recording->ticks().empty()) return fail(options.recording + " has no step", "", ExitCode::RecordingRefused);
    const std::int64_t last = recording->ticks().back();
    if (options.to && *options.to > last)
        return fail(fmt::format("{} ends with tick {}, before tick {}", options.recording, last, *options.to));
    const auto linked = find_code(p->linked, options.link, "--link");
    if (!linked) return tl::unexpected<Error>(linked.error());
    const auto extensions = find_code(p->extensions, options.extensions, "--extension");
    if (!extensions) return tl::unexpected<Error>(extensions.error());
    const fs::path folder = program_folder(scratch, *p);
    if (options.run.module.empty())
        if (auto written = write_program(scratch, *p); !written) return tl::unexpected<Error>(written.error());
    RunOptions run = options.run;
    run.program = (folder / p->program.front().path).string();
    for (const std::string& library : p->libraries) run.library_paths.push_back((folder / library).lexically_normal().string());
    run.link = *linked;
    run.extensions = *extensions;
    run.optimisation = p->optimisation;
    run.strict = p->strict;
    run.ticks = options.to.value_or(last);
    run.replay = options.recording;
    run.record = (fs::path(scratch) / "again.vtkhdf").string();
    return run;
}

}  // namespace

int replay_command(ReplayOptions options) {
    Scratch own;
    if (options.scratch.empty()) {
        const Result<std::string> made = own.make();
        if (!made) return tell(made.error());
        options.scratch = *made;
        options.run.arguments.insert(options.run.arguments.end(), {"--scratch", *made});
    }
    Result<RunOptions> run = run_again(options, options.scratch);
    if (!run) return tell(run.error());
    return run_command(std::move(*run));
}

Result<record::Provenance> provenance(const RunOptions& options, const ModuleInfo& module, const world::World& world) {
    record::Provenance p{.version = std::string(kVersion),
                         .program = {},
                         .libraries = {},
                         .optimisation = options.optimisation,
                         .linked = {},
                         .extensions = {},
                         .world_path = world.path,
                         .world = world.text,
                         .world_files = {},
                         .set = world.set,
                         .seed = world.seed,
                         .strict = options.strict};
    for (u32 i = 0; i < module.source_count; ++i) p.program.push_back({module.sources[i].path, module.sources[i].text});
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
    world->seed = p->seed;
    world->set = p->set;
    return world;
}

Result<std::unique_ptr<sim::SimModule>> make_check(const std::string& path) {
    const Result<record::RecordingReader> recording = record::RecordingReader::open(path);
    if (!recording) return tl::unexpected<Error>(recording.error());
    Result<record::Provenance> p = read_provenance(*recording);
    if (!p) return tl::unexpected<Error>(p.error());
    const Result<std::vector<Digest>> digests = recording->digests();
    if (!digests) return tl::unexpected<Error>(digests.error());
    std::map<std::int64_t, Digest> by_tick;
    for (std::size_t i = 0; i < digests->size(); ++i) by_tick[recording->ticks()[i]] = (*digests)[i];
    return std::make_unique<Check>(std::move(*p), std::move(by_tick));
}

Result<int> end_replay(const RunOptions& options, const Result<void>& ran, std::int64_t tick, comm::Communicator& comm) {
    if (!ran && ran.error().code != ExitCode::PropertyFailed) return tl::unexpected<Error>(ran.error());
    const Result<int> mine = comm.process() == 0 ? compare_and_print(options, ran, tick) : Result<int>(0);
    const Result<void> alike = comm::outcome_of_first(comm, mine.map([](int) {}));
    if (!alike) return tl::unexpected<Error>(alike.error());
    const std::byte code{static_cast<unsigned char>(*mine)};
    return static_cast<int>(comm.allgather({&code, 1}).front());
}

}  // namespace meld::driver
