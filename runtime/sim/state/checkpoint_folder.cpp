#include "runtime/sim/state/checkpoint_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/base/hash.h"
#include "runtime/comm/outcome.h"

namespace meld::sim {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::string_view kManifest = ".checkpoint.json", kShare = ".share";

std::string manifest_name(std::int64_t tick) { return fmt::format("{}{}", tick, kManifest); }

// The tick that a file of a checkpoint folder is of; none of other files.
std::optional<std::int64_t> tick_of(const std::string& name) {
    if (!name.ends_with(kManifest) && !name.ends_with(kShare)) return std::nullopt;
    std::int64_t tick = 0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), tick);
    if (error != std::errc{} || end == name.data() || *end != '.') return std::nullopt;
    return tick;
}

std::vector<std::string> names_in(const std::string& folder) {
    std::vector<std::string> names;
    std::error_code error;
    for (fs::directory_iterator each(folder, error), end; !error && each != end; each.increment(error))
        names.push_back(each->path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

json to_json(const Manifest& m) {
    return {{"claymeld", m.run.version},
            {"tick", m.tick},
            {"digest", m.digest},
            {"program", fmt::format("{:016x}", m.run.program)},
            {"schema", fmt::format("{:016x}", m.run.schema)},
            {"world", fmt::format("{:016x}", m.run.world)},
            {"seed", m.run.seed},
            {"folder", m.run.folder},
            {"command", m.run.command},
            {"shares", m.shares}};
}

std::uint64_t hexadecimal(const json& text) { return std::stoull(text.get<std::string>(), nullptr, 16); }

// Errors of the library are thrown; whoever reads catches them.
Manifest from_json(const json& j) {
    Manifest m;
    m.run.version = j.at("claymeld").get<std::string>();
    m.tick = j.at("tick").get<std::int64_t>();
    m.digest = j.at("digest").get<std::string>();
    m.run.program = hexadecimal(j.at("program"));
    m.run.schema = hexadecimal(j.at("schema"));
    m.run.world = hexadecimal(j.at("world"));
    m.run.seed = j.at("seed").get<std::uint64_t>();
    m.run.folder = j.at("folder").get<std::string>();
    m.run.command = j.at("command").get<std::vector<std::string>>();
    m.shares = j.at("shares").get<std::vector<std::string>>();
    return m;
}

tl::unexpected<Error> damaged(const std::string& path, const std::string& why) {
    return fail(path + ": " + why, "It is damaged, or was not written to its end", ExitCode::RecordingRefused);
}

// The last line is the hash of all before it.
Result<Manifest> read_manifest(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    std::ostringstream all;
    if (!(all << in.rdbuf())) return damaged(path, "the manifest cannot be read");
    const std::string text = all.str();
    const std::size_t line = text.size() < 2 ? std::string::npos : text.rfind('\n', text.size() - 2);
    if (line == std::string::npos ||
        text.substr(line + 1) != fmt::format("{:016x}\n", hash_text(std::string_view(text).substr(0, line + 1))))
        return damaged(path, "the manifest has other bytes than were written");
    try {
        return from_json(json::parse(text.substr(0, line)));
    } catch (const std::exception& e) {
        return damaged(path, fmt::format("the manifest is none of this version ({})", e.what()));
    }
}

Result<Checkpoint> read_checkpoint(const std::string& folder, std::int64_t tick) {
    Checkpoint out;
    const std::string path = (fs::path(folder) / manifest_name(tick)).string();
    Result<Manifest> manifest = read_manifest(path);
    if (!manifest) return tl::unexpected<Error>(manifest.error());
    out.manifest = std::move(*manifest);
    if (out.manifest.tick != tick || out.manifest.shares.empty()) return damaged(path, "the manifest is of another checkpoint");
    for (const std::string& share : out.manifest.shares) {
        // A name alone: a manifest cannot lead out of its folder.
        if (tick_of(share) != tick || share.find('/') != std::string::npos)
            return damaged(path, fmt::format("{} is none of its files", share));
        out.files.push_back((fs::path(folder) / share).string());
    }
    const Result<ShareFiles> files = ShareFiles::open(out.files);
    if (!files) return tl::unexpected<Error>(files.error());
    if (const Result<void> whole = files->check(); !whole) return tl::unexpected<Error>(whole.error());
    return out;
}

}  // namespace

std::string difference(const RunIdentity& of_checkpoint, const RunIdentity& now) {
    if (of_checkpoint.version != now.version)
        return fmt::format("it was made by Claymeld {}, and this is {}", of_checkpoint.version, now.version);
    if (of_checkpoint.program != now.program || of_checkpoint.schema != now.schema) return "the program has changed since";
    if (of_checkpoint.world != now.world) return "the world has changed since";
    if (of_checkpoint.seed != now.seed) return fmt::format("its seed was {}, and this one is {}", of_checkpoint.seed, now.seed);
    return "";
}

Result<CheckpointFolder> CheckpointFolder::open(const std::string& path, comm::Communicator& comm) {
    std::optional<OutputLock> lock;
    const auto take = [&]() -> Result<void> {
        std::error_code error;
        fs::create_directories(path, error);
        if (error) return fail(fmt::format("the folder for checkpoints {} cannot be made: {}", path, error.message()));
        Result<OutputLock> taken = OutputLock::take((fs::path(path) / "run").string(), path);
        if (!taken) return tl::unexpected<Error>(taken.error());
        lock = std::move(*taken);
        return {};
    };
    if (const auto all = comm::outcome_of_first(comm, comm.process() == 0 ? take() : Result<void>{}); !all)
        return tl::unexpected<Error>(all.error());
    CheckpointFolder folder(path, std::move(lock));
    for (const std::string& name : names_in(path))
        if (name.ends_with(kManifest))
            if (const auto tick = tick_of(name)) folder.last_ = std::max(folder.last_.value_or(*tick), *tick);
    return folder;
}

Result<void> CheckpointFolder::write(Manifest manifest, const std::function<Result<void>(ShareSink&)>& save, comm::Communicator& comm) {
    const auto name_of = [&](int rank) { return fmt::format("{}.{}-of-{}{}", manifest.tick, rank, comm.processes(), kShare); };
    std::uint64_t bytes = 0;
    const auto write_share = [&]() -> Result<void> {
        Result<std::unique_ptr<ShareWriter>> file = ShareWriter::create((fs::path(path_) / name_of(comm.process())).string());
        if (!file) return tl::unexpected<Error>(file.error());
        if (const Result<void> saved = save(**file); !saved) return saved;
        bytes = (*file)->bytes();
        return (*file)->close();
    };
    const Result<void> mine = write_share();
    ByteWriter told;
    told.write(bytes);
    told.write_string(mine ? "" : mine.error().message());
    Result<void> all;
    bytes_ = 0;
    for (const auto& theirs : comm.allgather_any(told.view())) {
        ByteReader in(theirs, "how a checkpoint was written");
        bytes_ += in.read<std::uint64_t>();
        if (const std::string problem = in.read_string(); all && !problem.empty()) all = fail(problem, "", ExitCode::LimitHit);
    }
    if (!all) return all;
    for (int rank = 0; rank < comm.processes(); ++rank) manifest.shares.push_back(name_of(rank));
    const auto write_manifest = [&]() -> Result<void> {
        Result<OutputFile> file =
            OutputFile::open((fs::path(path_) / manifest_name(manifest.tick)).string(), Appears::Whole, Durability::Machine);
        if (!file) return tl::unexpected<Error>(file.error());
        std::string text = to_json(manifest).dump(2) + "\n";
        text += fmt::format("{:016x}\n", hash_text(text));
        file->write(text);
        return file->commit();
    };
    all = comm::outcome_of_first(comm, comm.process() == 0 ? write_manifest() : Result<void>{});
    if (!all) return all;
    if (comm.process() == 0) forget_all_but(manifest.tick, last_.value_or(manifest.tick));
    last_ = manifest.tick;
    return {};
}

// What a run has left that stopped while it wrote goes too.
void CheckpointFolder::forget_all_but(std::int64_t newest, std::int64_t before) const {
    for (const std::string& name : names_in(path_)) {
        const std::optional<std::int64_t> tick = tick_of(name);
        std::error_code ignored;
        if (tick && *tick != newest && *tick != before) fs::remove(fs::path(path_) / name, ignored);
    }
}

Result<Checkpoint> newest_checkpoint(const std::string& folder) {
    std::vector<std::int64_t> ticks;
    for (const std::string& name : names_in(folder))
        if (name.ends_with(kManifest))
            if (const auto tick = tick_of(name)) ticks.push_back(*tick);
    std::sort(ticks.rbegin(), ticks.rend());
    std::string passed_over;
    for (const std::int64_t tick : ticks) {
        Result<Checkpoint> checkpoint = read_checkpoint(folder, tick);
        if (checkpoint) {
            checkpoint->passed_over = std::move(passed_over);
            return checkpoint;
        }
        passed_over += (passed_over.empty() ? "" : "\n") + checkpoint.error().problem;
    }
    if (ticks.empty())
        return fail(fmt::format("there is no checkpoint in {}", folder), "Give a folder that `meldsim run --checkpoint` wrote to",
                    ExitCode::RecordingRefused);
    return fail(fmt::format("no checkpoint in {} is whole:\n{}", folder, passed_over), "", ExitCode::RecordingRefused);
}

}  // namespace meld::sim
