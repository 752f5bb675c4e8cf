// Makes the rows of a study that are missing, several at a time, beside others who do the same.
#pragma once

#include "runtime/base/error.h"
#include "runtime/driver/study/row_store.h"
#include "runtime/driver/study/study_plan.h"

namespace meld::driver {

struct PoolOutcome {
    std::size_t made = 0;      // By this process.
    std::size_t missing = 0;   // Rows that nobody has made.
    bool interrupted = false;  // A signal came; what had been made is kept.
};

// Returns when every row has been made, by whomever. Errors: the folder cannot be written; no process can be started.
Result<PoolOutcome> make_rows(const StudyPlan& plan, RowStore& store, int jobs, bool quiet);

}  // namespace meld::driver
