// A measure of a study over a parameter, as a chart and in words.
#pragma once

#include <string>

#include "runtime/base/error.h"
#include "runtime/driver/study/study_table.h"
#include "runtime/show/render/chart.h"

namespace meld::driver {

struct StudyPlot {
    render::Chart chart;
    std::string said;  // Fits and tests, a line each.
};

// "Y~X": a line for each combination of the other parameters, programs and worlds, with medians and quartiles over the seeds; "Y~X|A,B":
// a line for each combination of the columns A and B alone, whatever the others are.
// If all numbers are above zero, both axes are logarithmic and each line has the power law that fits it; two programs are
// compared by a paired test. Rows that have failed are left out. Errors: there is no such column; it has no numbers.
Result<StudyPlot> plot_of(const StudyTable& table, const std::string& what);

// Writes it: SVG or PNG, by the name of the file.
Result<void> write_plot(const StudyPlot& plot, const std::string& path);

}  // namespace meld::driver
