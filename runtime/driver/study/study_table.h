// The rows of a study as a table: columns of names and cells of text, of numbers, or of nothing.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/driver/study/row_store.h"
#include "runtime/driver/study/study_plan.h"

namespace meld::driver {

using StudyCell = std::variant<std::monostate, std::int64_t, double, std::string>;

struct StudyTable {
    std::vector<std::string> columns;
    std::vector<std::vector<StudyCell>> rows;
    std::size_t first_measure = 0, measures = 0;  // Which columns are those.
    std::optional<std::size_t> column(std::string_view name) const;
};

// Why the run is not as the study wants it: it has failed, or it does not fulfil a demand, or a measure has no value. Empty: it is fine.
std::string failure_of(const RowResult& result, const Study& study);

// A row for each run that has been made: its number, program, world, parameters, seed, measures, and how it went.
StudyTable table_of(const StudyPlan& plan, const RowStore& store);

// A value of TOML or Meld as a cell: a number, if it is one.
StudyCell cell_of(const std::string& text);
std::string text_of(const StudyCell& cell);

std::string csv_text(const StudyTable& table);
// As SQLite, in one table `rows`, with the text of the study in a table `study`. Replaces the file.
Result<void> write_sqlite(const StudyTable& table, const Study& study, const std::string& path);

// For people: a line for each combination of parameters, over its seeds, with the number of runs, and of each measure the median and the
// quartiles; after a line of names.
std::vector<std::vector<std::string>> summary_lines(const StudyTable& table);
std::string summary_text(const StudyTable& table);

}  // namespace meld::driver
