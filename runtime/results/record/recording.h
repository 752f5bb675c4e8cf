// The recording of a run: positions and facts, step by step, in one HDF5 file that ParaView, h5py and our own tools read (VTKHDF 2.0,
// temporal PolyData), with an XDMF sidecar for older readers.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/base/error.h"
#include "runtime/base/files/output_file.h"
#include "runtime/base/hash.h"

namespace meld::record {

// The suffixes of the sidecars' names.
inline constexpr const char* kSidecar = ".xdmf";
inline constexpr const char* kLinesSidecar = ".lines.xdmf";

// Where the joints of a run are, and the columns of its steps with where theirs begin and how many there are.
inline constexpr const char* kJoints = "/meld/joints";
inline constexpr const char* kJointOffsets = "JointOffsets";
inline constexpr const char* kJointCount = "JointCount";

// What a run has counted, by name.
using RunCounts = std::vector<std::pair<std::string, std::int64_t>>;

// The properties of the run in a recording, in the group /meld of the file.
struct RecordingInfo {
    std::string program;
    std::string world;
    std::uint64_t seed = 0;
    std::vector<std::string> arguments;
    std::string lattice;
    double radius = 0;            // In metres.
    bool lines = false;           // Steps may have lines.
    bool all_whole = false;       // No step holds changes alone, as other programs than ours need it.
    std::string provenance = {};  // What it takes to run it again, as JSON; see provenance.h.
    std::string made_by = {};     // By what and how it was made, as JSON: for people, and no part of what the run is.
    // The names of what close() says how often it has happened.
    std::vector<std::string> counts = {};
    std::string predicates = "[]";  // What arrays and tables hold, as JSON.
    Durability durability = Durability::Process;
};

// A line between two catoms of a step, by their indices in it.
using RecordedLine = std::array<std::int64_t, 2>;

// One value (or vector of `components` values) for each catom of a step, in the order of its ids. The name "id" is taken, and none may
// contain '/', which HDF5 gives a meaning.
struct RecordedArray {
    // Of texts, std::strings, the file has each once, and the array the numbers of those under /meld/texts/TEXTS; −1 for the
    // empty text, which stands for none. An array of texts is in every step.
    enum Type { Int64, Float64, UInt8, Text };
    std::string name;
    Type type = Int64;
    const void* data = nullptr;
    int components = 1;
    std::string texts = {};  // Empty: the name of the array.
    bool same =
        false;  // As in the last step that was written, of as many rows. The data are looked at only if the step is whole after others.
    // The rows that differ from the last step that was written, of as many rows: these and no others, in their order. Null: nobody knows.
    const std::vector<std::uint64_t>* changed = nullptr;
};

// Facts of a step, or its joints, as many as there are; a column is an array with a value for each of them. Numbers are of 64 bits.
struct RecordedTable {
    enum class Kind { Facts, Joints };
    std::string name;
    std::uint64_t rows = 0;
    std::vector<RecordedArray> columns;
    bool same = false;  // As in the last step that was written, with all columns.
    Kind kind = Kind::Facts;
};

// What a step has in common with the last one that was written.
struct RecordedSame {
    bool ids = false;
    bool positions = false;
    const std::vector<std::uint64_t>* moved = nullptr;  // As RecordedArray::changed, of positions.
};

// A position as it stands in the file: floats of 32 bits suffice for viewing and halve the size.
using RecordedPosition = std::array<float, 3>;
RecordedPosition narrow(const std::array<double, 3>& position);

// Written by one process.
class Recording {
  public:
    // An existing recording is replaced when the new one is complete, at close(); until then the new one grows beside it. If it cannot be
    // started, nothing is left behind. Errors: a folder is missing, no permission, no space (exit code 4), the path is not a regular file.
    static Result<Recording> create(const std::string& path, const RecordingInfo& info);

    // Goes on with a recording from the state that save() wrote, perhaps in a process that is gone: the next step follows those of that
    // state. What the file has beyond it is cut off with that step, and nothing changes before. Errors: the file is gone, shorter, of
    // another run, or its last step is not the one that was written.
    static Result<Recording> reopen(const std::string& path, const RecordingInfo& info, ByteReader& saved);

    Recording(Recording&&) noexcept;
    Recording& operator=(Recording&&) noexcept;
    ~Recording();

    // Appends a step with the digest of the whole state: catoms sorted by id, as many positions as ids. Afterwards the file is complete up
    // to this step, also when the process is killed. What has not changed since the last step is stored as a reference, at no cost; what is
    // said to be the same is not even looked at. Of a large ensemble, a step with few changes holds these alone. An array that is missing
    // in some steps reads as zeros (floats: NaN) there. A table has the same columns in all steps.
    // Errors, all with exit code 4: no space for the step, which is then left out, and later ones may be tried; a failed write, after which
    // every call fails alike. Earlier steps remain readable.
    Result<void> step(double time, std::span<const RecordedPosition> positions, std::span<const std::uint64_t> ids,
                      std::span<const RecordedArray> arrays, std::span<const RecordedLine> lines = {},
                      std::span<const RecordedTable> tables = {}, const Digest& state = {}, const RecordedSame& same = {});

    // The state after the last step, for reopen(). There is one, and all arrays are in the first.
    void save(ByteWriter& out) const;
    // Makes sure that all steps so far are on the disk. Errors: it failed, and then nothing more is written.
    Result<void> secure();

    // What the run has counted, of RecordingInfo::counts; before close(). Without it a reader finds that nobody knows.
    void count(const RunCounts& counts);
    // Ends the file and writes its sidecars. Without it, or after a step that failed, an earlier recording stays, and so does what there is
    // of the new one.
    Result<void> close();

  private:
    struct State;
    explicit Recording(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace meld::record
