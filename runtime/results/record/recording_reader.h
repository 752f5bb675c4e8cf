// A recording read step by step: what runtime/results/record/recording.h writes, or what there is of it after a kill. A file from outside
// is never trusted: what it says is checked before memory is taken, and what does not fit is an error with exit code 6.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/base/hash.h"
#include "runtime/results/hdf5/hdf5_file.h"

namespace meld::record {

// A column in which every step has some rows: positions, an array of the catoms, or a column of a table of facts.
struct Series {
    std::string name;
    ElementType type = ElementType::Int64;
    int components = 1;
    std::string texts = {};  // The numbers are those of strings in the group of this name; empty: they are themselves.

    std::size_t row_bytes() const { return static_cast<std::size_t>(components) * size_of(type); }
};
using SeriesIndex = std::size_t;

// The facts of a predicate that can have several at a catom: its columns, the catom first, are series.
struct SeriesTable {
    std::string name;
    std::vector<SeriesIndex> columns;
};

// A predicate as the recording describes it: the arrays of its arguments, and whether it has a table.
struct DescribedPredicate {
    struct Argument {
        std::string name, type, array;
        bool operator==(const Argument&) const = default;
    };
    std::string name;
    bool table = false;
    std::vector<Argument> arguments = {};
    bool operator==(const DescribedPredicate&) const = default;
};

// The rows that a step has in a series: where they begin, and which of the series' changes count.
struct Rows {
    std::uint64_t first = 0, count = 0;
    std::uint64_t changes_begin = 0, changes_end = 0;
    bool operator==(const Rows&) const = default;
};

class RecordingReader {
  public:
    // Errors: it cannot be read, or is no recording of this version.
    static Result<RecordingReader> open(const std::string& path);
    RecordingReader(RecordingReader&&) noexcept;
    ~RecordingReader();

    const std::string& path() const;
    // What the run was: texts by name, such as "program" and "seed"; "provenance" is what provenance.h reads, and "made_by" and
    // "predicates" are JSON.
    std::string about(const std::string& name) const;
    // The command of the run, word by word.
    std::vector<std::string> arguments() const;
    // What the run had counted at its end, by name; none: nobody knows.
    std::vector<std::pair<std::string, std::uint64_t>> counts() const;
    // The tick of each step.
    const std::vector<std::int64_t>& ticks() const;
    // The digest of the whole state in each step. Errors: it has none.
    Result<std::vector<Digest>> digests() const;
    const std::vector<Series>& series() const;
    // Of each catom: positions, then ids, then all others by name. The ends of lines, as indices of catoms in the step.
    SeriesIndex points() const { return 0; }
    SeriesIndex ids() const { return 1; }
    const std::vector<SeriesIndex>& arrays() const;
    SeriesIndex line_ends() const;
    const std::vector<SeriesTable>& tables() const;
    // The joints of the run, if it has some: the columns are named as JointTable has them.
    const std::optional<SeriesTable>& joints() const;
    const std::vector<DescribedPredicate>& predicates() const;

    // The rows of a step in a series. Cost: mostly none, since a few thousand steps are read at a time.
    Result<Rows> rows(SeriesIndex series, std::size_t step);
    // Reads some of these rows, from the one with this number on, as they are in memory: row_bytes() each. Cost: with changes, also looks
    // at all of these, of which it keeps those of the last step that was asked for; they are fewer than the rows.
    Result<void> read(SeriesIndex series, const Rows& rows, std::uint64_t first, std::uint64_t count, void* to);
    // The strings of a group, by number. Cost: reads all of them the first time.
    Result<const std::vector<std::string>*> texts(const std::string& group);

  private:
    struct State;
    explicit RecordingReader(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace meld::record
