// A table of a recording with one row per step, such as the group /VTKHDF/Steps. Private to runtime/results.
//
// There are two copies, such as /meld/steps/0 and /meld/steps/1, written in turn; /VTKHDF/Steps is a link to the one that is complete. So a
// reader, even of a file whose writer was killed, never sees a table that is being written: all columns and NSteps agree.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "runtime/results/hdf5/hdf5_file.h"

namespace meld::record {

using StepColumn = std::size_t;

struct StepTablePlace {
    const char* group;        // With both copies.
    const char* seen_in;      // With the link, "Steps".
    bool seen_early = false;  // Readers may open it while it has no steps.
};

class StepTable {
  public:
    // The file must outlive the table. Makes the groups, and the link to a table without steps.
    StepTable(Hdf5File& file, const StepTablePlace& place);
    // Of a file that is opened again, in the state that save() wrote. Readers see the steps that there are until cut().
    StepTable(Hdf5File& file, const StepTablePlace& place, ByteReader& saved);
    void save(ByteWriter& out) const;
    // Whether the file has the steps of the saved state and the last of them is the same.
    bool matches() const;
    // Takes away the steps after the saved state: afterwards readers see none of them. Nothing of an earlier step is touched, and a
    // process that is killed in the midst of it leaves a file that can be cut once more.
    void cut();

    // A group in which columns may be.
    void make_group(const std::string& name);
    // A column of 64-bit numbers, `components` in a row. Of the steps that are there already it says 0.
    StepColumn add_column(const std::string& name, ElementType type, int components = 1);

    // Sets the value of a column for the step that is being made.
    void set(StepColumn column, std::int64_t value);
    void set(StepColumn column, double value);
    void set(StepColumn column, const std::array<std::int64_t, 4>& values);

    // Commits the step, with everything that is in the file so far.
    void commit();

    // What a column says of so many steps that count, a component after the other.
    std::vector<std::int64_t> read(StepColumn column, std::int64_t first, std::int64_t count) const;

    std::int64_t steps() const { return steps_; }

  private:
    struct Column {
        std::array<ColumnIndex, 2> in;       // In each table.
        std::array<std::int64_t, 4> last{};  // The values of the last step and of the one being made, bit by bit.
        std::array<std::int64_t, 4> next{};
        std::size_t components = 1;
    };
    std::string table(std::size_t number) const;
    void shorten(std::size_t number, std::int64_t rows);
    void show(std::size_t number);

    Hdf5File& file_;
    StepTablePlace place_;
    std::vector<Column> columns_;
    std::int64_t steps_ = 0;
};

}  // namespace meld::record
