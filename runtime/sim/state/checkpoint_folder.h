// The checkpoints of a run on disk: a folder with the last two snapshots, each the files of all processes and a manifest.
//
// A manifest is written when all files that it names are on the disk, and the files of an older snapshot go when there are two newer
// ones. So whatever happens to the run or to the machine, the newest manifest names a whole snapshot or the one before it does.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "runtime/base/output_lock.h"
#include "runtime/comm/communicator.h"
#include "runtime/sim/state/share_file.h"

namespace meld::sim {

// The run that a checkpoint is of. A run goes on from it only where all of this is the same, the command apart.
struct RunIdentity {
    std::string version;        // Of Claymeld.
    std::uint64_t schema = 0;   // Of the compiled program: its columns and predicates.
    std::uint64_t program = 0;  // The hash of its text.
    std::uint64_t world = 0;    // Of the world's text and all that it reads.
    std::uint64_t seed = 0;
    std::string folder;                // In which it was started.
    std::vector<std::string> command;  // As typed.
};

// What differs between the run of a checkpoint and one that is to go on from it, in words; empty: nothing.
std::string difference(const RunIdentity& of_checkpoint, const RunIdentity& now);

struct Manifest {
    std::int64_t tick = 0;
    std::string digest;  // Of the state, as `--digest` writes it.
    RunIdentity run;
    std::vector<std::string> shares;  // Names of files, by rank.
};

class CheckpointFolder {
  public:
    // Takes the folder for this run, and makes it if need be; process 0 holds the lock. Every process calls it. Errors: another run
    // writes to it, or it cannot be written.
    static Result<CheckpointFolder> open(const std::string& path, comm::Communicator& comm);

    // Writes a checkpoint: `save` gives this process's share. Every process calls it, and all return the same. Errors: a file cannot
    // be written; the checkpoints that were there before are still there.
    Result<void> write(Manifest manifest, const std::function<Result<void>(ShareSink&)>& save, comm::Communicator& comm);
    // By all processes, of the last checkpoint.
    std::uint64_t bytes() const { return bytes_; }

  private:
    CheckpointFolder(std::string path, std::optional<OutputLock> lock) : path_(std::move(path)), lock_(std::move(lock)) {}
    void forget_all_but(std::int64_t newest, std::int64_t before) const;

    std::string path_;
    std::optional<OutputLock> lock_;
    std::optional<std::int64_t> last_;  // The tick of the newest checkpoint here.
    std::uint64_t bytes_ = 0;
};

struct Checkpoint {
    Manifest manifest;
    std::vector<std::string> files;  // Paths of the shares, by rank.
    // Why newer checkpoints were passed over; mostly empty.
    std::string passed_over;
};

// The newest checkpoint of a folder that is whole. Errors: there is none, and why. Cost: all of it is read once to be checked.
Result<Checkpoint> newest_checkpoint(const std::string& folder);

}  // namespace meld::sim
