// Makes the rows of a study that are missing, several at a time, beside others who do the same.
#pragma once

#include <cstddef>
#include <cstdint>

#include "runtime/base/error.h"
#include "runtime/driver/study/row_store.h"
#include "runtime/driver/study/study_plan.h"

namespace meld::driver {

struct PoolOptions {
    int jobs = 1;                    // Runs at a time.
    bool quiet = false;              // There is no progress line.
    std::uint64_t memory_bytes = 0;  // What the runs may take together; 0: what the machine has free.
};

struct PoolOutcome {
    std::size_t made = 0;      // By this process.
    std::size_t missing = 0;   // Rows that nobody has made.
    bool interrupted = false;  // A signal came; what had been made is kept.
    // Runs that had to wait for memory, the most that one of them was expected to take, and how many ran at a time at the most.
    std::size_t held = 0;
    std::uint64_t held_bytes = 0;
    std::size_t most_at_once = 0;
};

// A run begins only where there is memory for what it is expected to take, and for what those that run may still take; one always runs.
// Returns when every row has been made, by whomever. Errors: the folder cannot be written; no process can be started.
Result<PoolOutcome> make_rows(const StudyPlan& plan, RowStore& store, const PoolOptions& options);

}  // namespace meld::driver
