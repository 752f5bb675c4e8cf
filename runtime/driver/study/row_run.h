// One run of a study, in a process of its own that begins as a copy of this one: the module is loaded, so it costs a few milliseconds, and
// whatever becomes of the run, the others do not see it. One that has not ended is killed with its RowRun.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "runtime/base/error.h"
#include "runtime/base/process/copied_process.h"
#include "runtime/driver/study/row_memory.h"
#include "runtime/driver/study/study_plan.h"

namespace meld::driver {

// The name of an expectation beside those of the study, whose outcome is among the demands of a result by this name.
inline constexpr std::string_view kStillName = "what must still hold";

// What there is to know of a run; runtime/driver/study/row_store.h says how it is kept.
struct RowResult {
    bool fine = false;  // It has ended well.
    int exit = 0;
    std::string reason = {};                                           // Why it has not.
    std::string ended = {};                                            // As in the summary; empty if it has failed.
    nlohmann::ordered_json counts = nlohmann::ordered_json::object();  // By name.
    // By text of the measure, and after "@TICK " for one that is taken after a tick; null: it has no value;
    // an object: the error.
    nlohmann::ordered_json measures = nlohmann::ordered_json::object();
    // By text of what is expected or may never be: what was found instead, or an empty text.
    nlohmann::ordered_json demands = nlohmann::ordered_json::object();
    std::string digest = {};              // Of the state at the end, as --digest writes it.
    double seconds = 0;                   // Of set-up and run.
    std::uint64_t memory = 0;             // At the peak.
    nlohmann::ordered_json made_by = {};  // runtime/driver/setup/made_by.h; null: an earlier version has made it.
};

nlohmann::ordered_json to_json(const RowResult& result);
// Nothing: it is not the text of a result.
std::optional<RowResult> row_result(const nlohmann::ordered_json& json);

// The name of a value of this measure in a result.
std::string measure_key(const StudyMeasure& measure, std::int64_t tick = 0);
std::string demand_key(const StudyDemand& demand);

// A run that has begun.
class RowRun {
  public:
    // It asks for memory() when its catoms have been counted, and goes on when it may. Errors: there can be no further process.
    static Result<RowRun> start(const StudyPlan& plan, std::size_t row);
    // A run with other options, whose program is this module, which asks for nothing; `number` is what row() returns.
    static Result<RowRun> start(const StudyPlan& plan, const RunOptions& options, const StudyModule& module, std::size_t number);
    std::size_t row() const { return row_; }
    // Readable when there is something to take().
    int descriptor() const { return process_.pipe(); }
    // Reads what there is; the result, when the process has ended.
    std::optional<RowResult> take();

    // Ends the run, if it has had more seconds than this, without those for which it had to wait; 0: it has all the time. Its result is
    // that.
    std::optional<RowResult> end_if_late(double most_seconds);

    // What it takes, once it has said so.
    const std::optional<RowMemory>& memory() const { return memory_; }
    // What it has taken since it began.
    std::uint64_t own_now() const;
    // Whether it has asked, and waits.
    bool waits() const { return memory_ && !may_go_on_; }
    void let_go_on();

  private:
    RowRun(CopiedProcess process, std::size_t number, std::optional<Gate> gate);
    static Result<RowRun> start(const StudyPlan& plan, const RunOptions& options, const StudyModule& module, std::size_t number,
                                std::optional<Gate> gate);
    void note_memory();
    RowResult finish();
    double begun_ = 0, asked_ = 0;  // When it has begun, and when it has asked for memory.
    std::size_t row_ = 0;
    CopiedProcess process_;
    std::optional<Gate> gate_;
    std::optional<RowMemory> memory_;
    bool may_go_on_ = false;
    std::string text_;
};

}  // namespace meld::driver
