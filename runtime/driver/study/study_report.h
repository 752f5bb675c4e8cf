// The results of a study as one page, which needs no server: table, plots, and the rows that have failed with their commands.
#pragma once

#include <string>
#include <vector>

#include "runtime/driver/study/study_plan.h"
#include "runtime/driver/study/study_plot.h"
#include "runtime/driver/study/study_table.h"

namespace meld::driver {

// Commands have paths from the folder of the study.
std::string report_page(const StudyPlan& plan, const StudyTable& table, const std::vector<StudyPlot>& plots);

}  // namespace meld::driver
