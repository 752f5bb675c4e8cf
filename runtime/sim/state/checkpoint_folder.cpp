#include "runtime/sim/state/checkpoint_folder.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <sstream>

#include "runtime/base/assert.h"
#include "runtime/base/byte_text.h"
#include "runtime/base/bytes.h"
#include "runtime/base/hash.h"
#include "runtime/base/shallow_json.h"
#include "runtime/comm/transport/collective_result.h"

namespace meld::sim {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// To open a checkpoint of a run that goes on meanwhile.
constexpr int kMostTries = 20;

constexpr off_t kMostOfAManifest_bytes = 1 << 24;
// A chain is as long as its changes take at most this part of the whole one, and has no more checkpoints than a process may open files.
constexpr std::uint64_t kMostChanges = 2;
constexpr int kMostInChain = 250;
constexpr std::string_view kManifest = ".checkpoint.json", kShare = ".share";

std::string manifest_name(std::int64_t tick) { return fmt::format("{}{}", tick, kManifest); }

// What a run has left that was killed while it wrote a manifest (runtime/base/files/output_file.h).
bool is_part_of_manifest(const std::string& name) { return name.find(".checkpoint.part-") != std::string::npos && name.ends_with(".json"); }

// The tick that a file of a checkpoint folder is of; none of other files.
std::optional<std::int64_t> tick_of(const std::string& name) {
    if (!name.ends_with(kManifest) && !name.ends_with(kShare) && !is_part_of_manifest(name)) return std::nullopt;
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
    json traits = json::array(), command = json::array();
    for (const Trait& t : m.run.traits)
        traits.push_back({{"name", t.name}, {"shown", text_of_bytes(t.shown)}, {"hash", fmt::format("{:016x}", t.hash)}});
    for (const std::string& word : m.run.command) command.push_back(text_of_bytes(word));
    json world = json::object();
    for (const auto& [part, hash] : m.run.world) world[part] = fmt::format("{:016x}", hash);
    json all = {
        {"tick", m.tick},     {"digest", m.digest}, {"run", traits},        {"world", world},    {"folder", text_of_bytes(m.run.folder)},
        {"command", command}, {"shares", m.shares}, {"made_by", m.made_by}, {"counts", m.counts}};
    if (m.changes_since) all["changes_since"] = *m.changes_since;
    return all;
}

// Errors of the library are thrown; whoever reads catches them.
Manifest from_json(const json& j) {
    Manifest m;
    m.tick = whole_number<std::int64_t>(j.at("tick"));
    m.digest = j.at("digest").get<std::string>();
    for (const json& t : j.at("run"))
        m.run.traits.push_back({t.at("name").get<std::string>(), bytes_of_text(t.at("shown").get<std::string>()),
                                std::stoull(t.at("hash").get<std::string>(), nullptr, 16)});
    for (const auto& [part, hash] : j.at("world").items()) m.run.world[part] = std::stoull(hash.get<std::string>(), nullptr, 16);
    m.run.folder = bytes_of_text(j.at("folder").get<std::string>());
    for (const json& word : j.at("command")) m.run.command.push_back(bytes_of_text(word.get<std::string>()));
    m.shares = j.at("shares").get<std::vector<std::string>>();
    m.made_by = j.value("made_by", "");
    m.counts = j.value("counts", "");
    if (j.contains("changes_since")) m.changes_since = whole_number<std::int64_t>(j.at("changes_since"));
    return m;
}

tl::unexpected<Error> damaged_checkpoint(const std::string& path, const std::string& why) {
    return fail(path + ": " + why, "It is damaged, or was not written to its end", ExitCode::RecordingRefused);
}

// A manifest names a command, which is run again: that of another user is not.
Result<void> check_ours(const std::string& path) {
    struct stat status{};
    if (lstat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode) || status.st_size > kMostOfAManifest_bytes)
        return damaged_checkpoint(path, "the manifest is no file of ours");
    if (status.st_uid == geteuid()) return {};
    return fail(fmt::format("{}: the manifest belongs to another user", path), "Copy the folder if you trust the command in it",
                ExitCode::RecordingRefused);
}

// The last line is the hash of all before it.
Result<Manifest> read_manifest(const std::string& path) {
    if (auto ours = check_ours(path); !ours) return tl::unexpected<Error>(ours.error());
    std::ifstream in(path, std::ios::binary);
    std::ostringstream all;
    if (!(all << in.rdbuf())) return damaged_checkpoint(path, "the manifest cannot be read");
    const std::string text = all.str();
    const std::size_t line = text.size() < 2 ? std::string::npos : text.rfind('\n', text.size() - 2);
    if (line == std::string::npos ||
        text.substr(line + 1) != fmt::format("{:016x}\n", hash_text(std::string_view(text).substr(0, line + 1))))
        return damaged_checkpoint(path, "the manifest has other bytes than were written");
    try {
        return from_json(json::parse(text.substr(0, line)));
    } catch (const std::exception& e) {
        return damaged_checkpoint(path, fmt::format("the manifest is none of this version ({})", e.what()));
    }
}

// The manifest of a tick and the paths of its shares, which are not looked at.
Result<Checkpoint> read_checkpoint(const std::string& folder, std::int64_t tick) {
    Checkpoint out;
    const std::string path = (fs::path(folder) / manifest_name(tick)).string();
    Result<Manifest> manifest = read_manifest(path);
    if (!manifest) return tl::unexpected<Error>(manifest.error());
    out.manifest = std::move(*manifest);
    if (out.manifest.tick != tick || out.manifest.shares.empty()) return damaged_checkpoint(path, "the manifest is of another checkpoint");
    for (const std::string& share : out.manifest.shares) {
        // A name alone: a manifest cannot lead out of its folder.
        if (tick_of(share) != tick || share.find('/') != std::string::npos)
            return damaged_checkpoint(path, fmt::format("{} is none of its files", share));
        out.files.push_back((fs::path(folder) / share).string());
    }
    return out;
}

// The newest of these ticks of a folder for which check() has no objection.
template <class Check>
Result<Checkpoint> newest_of(const std::vector<std::int64_t>& ticks, const std::string& folder, const Check& check) {
    std::string passed_over;
    for (auto tick = ticks.rbegin(); tick != ticks.rend(); ++tick) {
        Result<Checkpoint> checkpoint = read_checkpoint(folder, *tick);
        Result<void> whole;
        if (checkpoint) whole = check(*checkpoint);
        if (checkpoint && whole) {
            checkpoint->passed_over = std::move(passed_over);
            return checkpoint;
        }
        passed_over += (passed_over.empty() ? "" : "; ") + (checkpoint ? whole.error() : checkpoint.error()).problem;
    }
    if (ticks.empty())
        return fail(fmt::format("there is no checkpoint in {}", folder), "Give a folder that `meldsim run --checkpoint` has written to",
                    ExitCode::RecordingRefused);
    return fail(fmt::format("no checkpoint in {} is whole: {}", folder, passed_over),
                "Start the run again, with another folder for its checkpoints", ExitCode::RecordingRefused);
}

// The newest of a folder, or of those before a tick, for which check() has no objection.
template <class Check>
Result<Checkpoint> find_newest(const std::string& folder, std::optional<std::int64_t> before, const Check& check) {
    const auto known = [&] {
        std::vector<std::int64_t> ticks = checkpoint_ticks(folder);
        if (before) std::erase_if(ticks, [&](std::int64_t tick) { return tick >= *before; });
        return ticks;
    };
    for (int tries = 1;; ++tries) {
        const std::vector<std::int64_t> ticks = known();
        Result<Checkpoint> newest = newest_of(ticks, folder, check);
        // A run that goes on there may have removed all of them meanwhile; there are newer ones then.
        if (newest || tries >= kMostTries || known() == ticks) return newest;
    }
}

}  // namespace

std::string difference(const RunIdentity& of_checkpoint, const RunIdentity& now) {
    for (const Trait& was : of_checkpoint.traits)
        for (const Trait& is : now.traits) {
            if (was.name != is.name || was.hash == is.hash) continue;
            return was.shown != is.shown ? fmt::format("{} was '{}', and is '{}'", was.name, was.shown, is.shown)
                                         : fmt::format("{}, {}, has changed since", was.name, was.shown);
        }
    return of_checkpoint.traits.size() == now.traits.size() ? "" : "it was made by another version of Claymeld";
}

std::vector<std::int64_t> checkpoint_ticks(const std::string& folder) {
    std::vector<std::int64_t> ticks;
    for (const std::string& name : names_in(folder))
        if (name.ends_with(kManifest))
            if (const auto tick = tick_of(name)) ticks.push_back(*tick);
    std::sort(ticks.begin(), ticks.end());
    return ticks;
}

Result<Checkpoint> checkpoint_of(const std::string& folder, std::int64_t tick) { return read_checkpoint(folder, tick); }

Result<Manifest> newest_manifest(const std::string& folder) {
    return find_newest(folder, {}, [](const Checkpoint&) { return Result<void>(); }).map([](Checkpoint c) {
        return std::move(c.manifest);
    });
}

Result<OpenCheckpoint> open_newest(const std::string& folder, comm::Communicator& comm, std::optional<std::int64_t> before) {
    const bool first = comm.process() == 0;
    std::map<std::int64_t, Error> bad;  // On process 0: those that are not whole.
    for (int tries = 1;; ++tries) {
        std::optional<ShareFiles> shares;
        const auto take = [&](const Checkpoint& checkpoint) -> Result<void> {
            if (const auto known = bad.find(checkpoint.manifest.tick); known != bad.end()) return tl::unexpected<Error>(known->second);
            Result<ShareFiles> files = ShareFiles::open(checkpoint.files);
            if (!files) return tl::unexpected<Error>(files.error());
            shares.emplace(std::move(*files));
            return {};
        };
        Result<Checkpoint> mine = first ? find_newest(folder, before, take) : Result<Checkpoint>();
        const Result<void> found = mine ? Result<void>() : tl::unexpected<Error>(mine.error());
        if (const auto all = comm::outcome_of_first(comm, found); !all) return tl::unexpected<Error>(all.error());
        ByteWriter out;
        out.write(mine->manifest.tick);
        const auto ticks = comm.allgather_any(out.view());
        const auto tick = ByteReader(ticks[0], "the tick of the newest checkpoint").read<std::int64_t>();
        if (!first) mine = read_checkpoint(folder, tick);
        const Result<void> held = !mine ? tl::unexpected<Error>(mine.error()) : shares ? Result<void>() : take(*mine);
        if (const auto all = comm::outcome_of_all(comm, held); !all) {
            // A run that goes on there may have removed it just now; there is a newer one then.
            if (tries < kMostTries) continue;
            return tl::unexpected<Error>(all.error());
        }
        const Result<void> whole = first ? shares->check() : Result<void>();
        if (comm::outcome_of_first(comm, whole)) return OpenCheckpoint{std::move(*mine), std::move(*shares)};
        if (first) bad.emplace(tick, whole.error());
    }
}

Result<CheckpointFolder> CheckpointFolder::open(const std::string& path, Run run, comm::Communicator& comm, Stores stores) {
    std::optional<OutputLock> lock;
    const auto take = [&]() -> Result<void> {
        std::error_code error;
        if (run == Run::Begins) fs::create_directories(path, error);
        if (error)
            return fail(fmt::format("the folder {} for checkpoints cannot be made: {}", path, error.message()),
                        "Choose another one with --checkpoint");
        Result<OutputLock> taken = OutputLock::take((fs::path(path) / "run").string(), path);
        if (!taken) return tl::unexpected<Error>(taken.error());
        lock = std::move(*taken);
        const std::vector<std::string> names = names_in(path);
        if (run == Run::Begins && std::any_of(names.begin(), names.end(), [](const std::string& n) { return n.ends_with(kManifest); }))
            return fail(fmt::format("{} has checkpoints of an earlier run", path),
                        fmt::format("Go on with that run by `meldsim resume {}`, or choose another folder", path));
        return {};
    };
    if (const auto all = comm::outcome_of_first(comm, comm.process() == 0 ? take() : Result<void>{}); !all)
        return tl::unexpected<Error>(all.error());
    return CheckpointFolder(path, std::move(lock), stores);
}

Result<OpenCheckpoint> CheckpointFolder::newest(comm::Communicator& comm) {
    Result<OpenCheckpoint> found = open_newest(path_, comm);
    if (found) {
        const Manifest& manifest = found->checkpoint.manifest;
        last_ = manifest.tick;
        chain_ = {manifest.changes_since.value_or(manifest.tick), manifest.tick};
    }
    if (found && comm.process() == 0) forget_unnamed();
    return found;
}

Result<void> CheckpointFolder::write(Manifest manifest, const std::function<Result<void>(ShareSink&)>& save,
                                     const std::function<std::string()>& digest, comm::Communicator& comm) {
    const auto name_of = [&](int process) { return fmt::format("{}.{}-of-{}{}", manifest.tick, process, comm.processes(), kShare); };
    const std::string path = (fs::path(path_) / name_of(comm.process())).string();
    // A file cannot refer to itself as it was.
    const bool whole = stores_ == Stores::Everything || blocks_.files.empty() || last_ == manifest.tick;
    const WrittenBlocks none;
    Result<std::unique_ptr<ShareWriter>> share =
        stores_ == Stores::Everything ? ShareWriter::create(path) : ShareWriter::create(path, whole ? none : blocks_);
    if (!whole) manifest.changes_since = chain_->first;
    // As much as the last whole one took: a disk that is too full is found before all of it is written.
    Result<void> all =
        comm::outcome_of_all(comm, share ? (*share)->reserve(whole ? share_bytes_ : 0) : tl::unexpected<Error>(share.error()));
    if (!all) return all;
    all = comm::outcome_of_all(comm, save(**share));
    if (!all) return all;
    const std::uint64_t bytes = (*share)->size();
    if (whole) share_bytes_ = bytes;
    manifest.digest = digest();
    all = comm::outcome_of_all(comm, (*share)->close());
    WrittenBlocks written;
    if (stores_ == Stores::Changes) written = (*share)->take_written();
    share->reset();
    if (!all) return all;
    for (int process = 0; process < comm.processes(); ++process) manifest.shares.push_back(name_of(process));
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
    blocks_ = std::move(written);
    note_written(manifest.tick, whole, bytes, comm);
    if (comm.process() == 0) {
        forget_older();
        forget_unnamed();
    }
    return {};
}

// All processes come to the same end of a chain.
void CheckpointFolder::note_written(std::int64_t tick, bool whole, std::uint64_t bytes, comm::Communicator& comm) {
    last_ = tick;
    if (whole) {
        if (chain_ && !chain_->has(tick)) before_ = chain_;
        chain_ = {tick, tick};
        whole_bytes_ = changed_bytes_ = 0;
        in_chain_ = 0;
    }
    chain_->last = tick;
    if (stores_ == Stores::Everything) return;
    std::uint64_t sum = 0;
    const std::vector<std::byte> of_all = comm.allgather(std::as_bytes(std::span(&bytes, 1)));
    ByteReader in(of_all, "the sizes of shares");
    for (int process = 0; process < comm.processes(); ++process) sum += in.read<std::uint64_t>();
    (whole ? whole_bytes_ : changed_bytes_) += sum;
    // A resume opens all files that the last one refers to.
    if (changed_bytes_ * kMostChanges > whole_bytes_ || ++in_chain_ >= kMostInChain) blocks_ = {};
}

// What a run has left that stopped while it wrote goes too, and the lock on that.
void CheckpointFolder::forget_older() const {
    for (const std::string& name : names_in(path_)) {
        const std::optional<std::int64_t> tick = tick_of(OutputLock::locked_by(name).value_or(name));
        std::error_code ignored;
        if (tick && !chain_->has(*tick) && !(before_ && before_->has(*tick))) fs::remove(fs::path(path_) / name, ignored);
    }
}

// What a run on another number of processes has left of the same ticks. Of a tick whose manifest is damaged nothing is removed.
void CheckpointFolder::forget_unnamed() const {
    std::set<std::string> named;
    std::set<std::int64_t> unknown;
    for (const std::int64_t tick : checkpoint_ticks(path_)) {
        const Result<Checkpoint> checkpoint = read_checkpoint(path_, tick);
        if (!checkpoint) {
            unknown.insert(tick);
            continue;
        }
        named.insert(manifest_name(tick));
        named.insert(checkpoint->manifest.shares.begin(), checkpoint->manifest.shares.end());
    }
    for (const std::string& name : names_in(path_)) {
        const std::string file = OutputLock::locked_by(name).value_or(name);
        const std::optional<std::int64_t> tick = tick_of(file);
        std::error_code ignored;
        if (tick && !unknown.contains(*tick) && !named.contains(file)) fs::remove(fs::path(path_) / name, ignored);
    }
}

}  // namespace meld::sim
