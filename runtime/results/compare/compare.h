// Compares what two runs have left: digests, recordings, facts, checkpoints. Large files are read piece by piece.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/base/terminal/progress.h"
#include "runtime/results/compare/report.h"
#include "runtime/sim/state/checkpoint_folder.h"

namespace meld::compare {

enum class Kind { Digests, Recording, TextFacts, CsvFile, CsvFolder, Hdf5Facts, Checkpoints, Empty };

// What is at a path, by what is in it. An empty file may be digests or facts. Errors: nothing that meldsim writes.
Result<Kind> kind_of(const std::string& path);
// "a recording", for messages.
const char* name_of(Kind kind);

// The first tick of two digest files that differs.
Result<Report> compare_digests(const std::string& a, const std::string& b, Progress& progress);

// The differences by predicate, with at most so many examples of each. Errors: a file is not as meldsim writes it; text and tables are
// not compared with each other.
Result<Report> compare_facts(const std::string& a, Kind kind_a, const std::string& b, Kind kind_b, std::uint64_t most_examples,
                             Progress& progress);

// The first step that differs, of those of the same tick, and the least catom in it, or only the digest of the whole state if nothing that
// is recorded differs. Floats differ where their bits do.
// Whether a file begins as recordings and tables in HDF5 do, also one that is damaged behind that.
bool begins_as_hdf5(const std::string& path);

Result<Report> compare_recordings(const std::string& a, const std::string& b, Progress& progress);

// The state in a checkpoint, loaded.
class State {
  public:
    struct Catom {
        std::uint64_t id = 0, hash = 0;  // Of all that lines() tells.
    };
    virtual ~State() = default;
    // By ids.
    virtual std::vector<Catom> catoms() const = 0;
    // Where the catom is and what it holds, a line each, in order; empty if it is not there.
    virtual std::vector<std::string> lines(std::uint64_t id) const = 0;
};
// Errors: the program or the world has changed since, or the checkpoint is damaged.
using LoadState = std::function<Result<std::unique_ptr<State>>(const sim::Checkpoint&)>;

// Of the newest tick of which both folders have a checkpoint, or else of the newest of each: what differs in the runs, and the least catom
// whose place or facts do. Holds one state at a time in memory, and none if the digests are equal.
Result<Report> compare_checkpoints(const std::string& a, const std::string& b, const LoadState& load, Progress& progress);

}  // namespace meld::compare
