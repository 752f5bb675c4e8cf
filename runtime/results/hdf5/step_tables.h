// The steps of a recording: the whole ones in /VTKHDF/Steps, and those that hold only changes in /meld/changes/Steps. Private to
// runtime/results.
//
// A step is in one of the two tables, so each has its own link and a kill leaves both complete. The second also says the number of each of
// its steps among all; a reader that reads it after the first finds out from it whether the first has grown in the meantime.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "runtime/results/hdf5/step_table.h"

namespace meld::record {

class StepTables {
  public:
    // As for StepTable.
    explicit StepTables(Hdf5File& file);
    StepTables(Hdf5File& file, ByteReader& saved);
    void save(ByteWriter& out) const;
    bool matches() const;
    void cut();

    // Makes the table of steps that hold only changes. Before the first step.
    void follow_changes();
    bool follows_changes() const { return partial_.has_value(); }

    // Both tables have these groups and columns.
    void make_group(const std::string& name);
    StepColumn add_column(const std::string& name, ElementType type, int components = 1);
    // Which changes count in a step: only the table of changes has this one.
    StepColumn add_range(const std::string& name) { return partial_->add_column(name, ElementType::Int64, 2); }

    template <class Value>
    void set(StepColumn column, const Value& value) {
        whole_.set(column, value);
        if (partial_) partial_->set(in_partial_[column], value);
    }
    void set_range(StepColumn range, std::int64_t begin, std::int64_t end) { partial_->set(range, std::array{begin, end, kNone, kNone}); }

    void commit_whole() { whole_.commit(); }
    void commit_changes();

    // Of all steps, and of those that are whole.
    std::int64_t steps() const { return whole_.steps() + (partial_ ? partial_->steps() : 0); }
    const StepTable& whole() const { return whole_; }

  private:
    static constexpr std::int64_t kNone = 0;
    // What both tables have; without components it is a group.
    struct Made {
        std::string name;
        ElementType type = ElementType::Int64;
        int components = 0;
    };

    Hdf5File& file_;
    StepTable whole_;
    std::optional<StepTable> partial_;
    StepColumn number_ = 0;               // In the table of changes: which of all steps it is.
    std::vector<StepColumn> in_partial_;  // By column of the other table.
    std::vector<Made> made_;              // Before the table of changes.
};

}  // namespace meld::record
