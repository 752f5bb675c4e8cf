// The checkpoints of a run on disk: a folder with the last two snapshots, each the files of all processes and a manifest.
//
// If they are to take what changes, a snapshot refers to the files of those before it for what is as it was there. They go back to a whole
// one, and together are a chain. When the changes of a chain take half as much as its whole snapshot, another one begins. The folder then
// has the last two chains.
//
// A manifest is written when all files that it names are on the disk, and the files of an older snapshot go when there are two newer
// ones. So whatever happens to the run or to the machine, the newest manifest names a whole snapshot or the one before it does.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/base/files/output_lock.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/sim/state/share_file.h"

namespace meld::sim {

// Something that must be the same for a run to go on from a checkpoint: "the world", as people know it, and a hash of what is in it.
struct Trait {
    std::string name;
    std::string shown;
    std::uint64_t hash = 0;
};

// The run that a checkpoint is of.
struct RunIdentity {
    std::vector<Trait> traits;
    std::map<std::string, std::uint64_t> world = {};  // The parts of its world, by World::parts.
    std::string folder;                               // In which it was started.
    std::vector<std::string> command;                 // As typed.
};

// What differs between the run of a checkpoint and one that is to go on from it, in words; empty: nothing.
std::string difference(const RunIdentity& of_checkpoint, const RunIdentity& now);

struct Manifest {
    std::int64_t tick = 0;
    std::string digest;  // Of the state, as `--digest` writes it.
    RunIdentity run;
    std::vector<std::string> shares;  // Names of files, by process.
    // The tick of the whole snapshot with which its chain begins, if it is not that itself.
    std::optional<std::int64_t> changes_since = {};
    // For people: by what it was made, and what the run had counted, as JSON. Empty: an earlier version has written it.
    std::string made_by = {}, counts = {};
};

struct Checkpoint {
    Manifest manifest;
    std::vector<std::string> files;  // Paths of the shares, by process.
    // Why newer checkpoints were passed over; mostly empty.
    std::string passed_over;
};

// The newest manifest that is whole; its shares are not looked at. Errors: there is none, and why.
Result<Manifest> newest_manifest(const std::string& folder);

// The ticks of which a folder has a manifest, in order; none if it is no folder.
std::vector<std::int64_t> checkpoint_ticks(const std::string& folder);
// The checkpoint of one of these ticks; its shares are not looked at. Errors: the manifest is damaged or another user's.
Result<Checkpoint> checkpoint_of(const std::string& folder, std::int64_t tick);

// A checkpoint that can be read to its end, whatever a run that writes to its folder does meanwhile (see ShareFiles).
struct OpenCheckpoint {
    Checkpoint checkpoint;
    ShareFiles shares;
};
// The newest checkpoint of a folder that is whole, the same on all processes; every process calls it. Errors: there is none, and why.
// Of those before tick `before`, if that is given. Cost: process 0 reads all of it once to check it.
Result<OpenCheckpoint> open_newest(const std::string& folder, comm::Communicator& comm, std::optional<std::int64_t> before = {});

class CheckpointFolder {
  public:
    // Takes the folder for this run, and makes it if need be; process 0 holds the lock. Collective, as all that follows. Errors:
    // another run writes to it, or it cannot be written; for a run that begins, it has checkpoints already.
    enum class Run { Begins, GoesOn };
    enum class Stores { Everything, Changes };
    static Result<CheckpointFolder> open(const std::string& path, Run run, comm::Communicator& comm, Stores stores = Stores::Everything);

    // open_newest() of this folder; the next one to be written is its successor.
    Result<OpenCheckpoint> newest(comm::Communicator& comm);

    // Writes a checkpoint: `save` gives this process's share, and then `digest` that of the state, while the disk writes. Both are
    // collective. All processes return the same. Errors: a file cannot be written; the checkpoints that were there before are still there.
    Result<void> write(Manifest manifest, const std::function<Result<void>(ShareSink&)>& save, const std::function<std::string()>& digest,
                       comm::Communicator& comm);
    // The tick of the last one that is whole.
    std::optional<std::int64_t> last() const { return last_; }
    const std::string& path() const { return path_; }
    bool stores_changes() const { return stores_ == Stores::Changes; }

  private:
    // Ticks of checkpoints, from that of a whole one on.
    struct Chain {
        std::int64_t first = 0, last = 0;
        bool has(std::int64_t tick) const { return first <= tick && tick <= last; }
    };
    CheckpointFolder(std::string path, std::optional<OutputLock> lock, Stores stores)
        : path_(std::move(path)), lock_(std::move(lock)), stores_(stores) {}
    void note_written(std::int64_t tick, bool whole, std::uint64_t bytes, comm::Communicator& comm);
    void forget_older() const;
    void forget_unnamed() const;

    std::string path_;
    std::optional<OutputLock> lock_;
    std::optional<std::int64_t> last_;
    Stores stores_;
    std::optional<Chain> chain_, before_;  // That of the last one, and the one before.
    std::uint64_t share_bytes_ = 0;        // Of this process, in the last whole one that it wrote.
    WrittenBlocks blocks_;                 // Of this process, in the last one; none before a whole one.
    // What the whole one of this chain and the changes after it take, of all processes.
    std::uint64_t whole_bytes_ = 0, changed_bytes_ = 0;
    int in_chain_ = 0;  // Checkpoints of this chain.
};

}  // namespace meld::sim
