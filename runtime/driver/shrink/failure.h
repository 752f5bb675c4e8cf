// How a row of a study fails, such that a smaller run can be said to fail in the same way.
#pragma once

#include <optional>
#include <string>

#include "runtime/driver/study/row_run.h"
#include "runtime/driver/study/study_file.h"

namespace meld::driver {

struct Failure {
    enum class Kind {
        Expect,     // What is expected does not hold at the end.
        Never,      // What may never hold has held.
        Measure,    // A measure has no value. The run itself is fine.
        TimeLimit,  // The time limit of the study has passed.
        Signal,     // The process of the run was ended by a signal.
        Error,      // The run has ended with an error.
    } kind = Kind::Error;
    int exit = 0;
    // Which expectation or measure; of an error its text, without the numbers of catoms and ticks and the name of the world, which are
    // others in a smaller run.
    std::string what = {};
    std::string ended = {};  // As in the summary; empty if it did not end well.
    std::int64_t ticks = 0;  // That the run had made.

    // Whether all of the run counts, and not only what has happened so far: a run cut short says nothing of what is expected at its end.
    bool of_the_end() const { return kind == Kind::Expect || kind == Kind::TimeLimit; }
};

// Nothing: it is fine. The world is that of the run.
std::optional<Failure> failure_in(const RowResult& result, const Study& study, const std::string& world_path);

// Whether `other` is the same failure. What is expected at the end counts if the run has ended of itself as the first one did; one that
// stopped after its last tick may also come to rest before.
bool same_failure(const Failure& failure, const Failure& other);

// The text without what differs between runs of the same fault: each number but those of lines of the program, and the path of the world.
std::string without_numbers(const std::string& text, const std::string& world_path);

}  // namespace meld::driver
