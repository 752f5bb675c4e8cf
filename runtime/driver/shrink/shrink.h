// `meldsim sweep --shrink`: the smallest world that was found in which a row of a study fails as it does.
#pragma once

#include <cstddef>

#include "runtime/base/error.h"
#include "runtime/driver/study/row_store.h"
#include "runtime/driver/study/study_plan.h"
#include "runtime/driver/study/sweep_options.h"

namespace meld::driver {

// Writes the world into the folder of the results, and prints what became of it and the command that runs it. Returns the exit code.
// Errors: the row does not fail, or not in a way that a run shows; the disk is full.
Result<int> shrink_row(const SweepOptions& options, StudyPlan& plan, const RowStore& store, std::size_t row);

}  // namespace meld::driver
