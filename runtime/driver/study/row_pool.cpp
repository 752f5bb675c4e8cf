#include "runtime/driver/study/row_pool.h"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "runtime/base/process/available_memory.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/base/process/stage_clock.h"
#include "runtime/base/terminal/progress.h"
#include "runtime/base/units.h"
#include "runtime/driver/study/study_table.h"

namespace meld::driver {

namespace {

constexpr int kWait_ms = 200;
constexpr double kRefresh_s = 1;
// Reading the journals of many takes its time; no more than this part of the time is spent on it.
constexpr double kRefreshPart = 0.05;

class RowPool {
  public:
    RowPool(const StudyPlan& plan, RowStore& store, const PoolOptions& options)
        : plan_(plan), store_(store), options_(options), jobs_(static_cast<std::size_t>(options.jobs)), begun_(seconds_now()) {
        if (!options.quiet) progress_.emplace();
        for (std::size_t row = 0; row < plan.rows().size(); ++row) {
            if (const RowResult* const result = store.find(plan.rows()[row], plan.study()))
                note_peak(row, *result);
            else
                todo_.push_back(row);
        }
        total_ = todo_.size();
    }

    Result<PoolOutcome> run();

  private:
    // Rows that differ in their seeds alone.
    using Kind = std::tuple<std::size_t, std::string, std::vector<std::string>>;
    Kind kind_of(std::size_t row) const { return {plan_.rows()[row].module, plan_.rows()[row].world_path, plan_.rows()[row].set}; }
    void note_peak(std::size_t row, const RowResult& result);
    bool is_made(std::size_t row) const { return store_.find(plan_.rows()[row], plan_.study()) != nullptr; }
    Result<void> start_more();
    Result<void> collect();
    // Lets runs go on that have asked for memory, in the order in which they began.
    void give_memory();
    std::uint64_t expected_own(const RowRun& run) const;
    bool fits(const RowRun& run) const;
    void look_at_others();
    // How many run and have the memory that they asked for.
    std::size_t with_memory() const;
    std::string line() const;

    const StudyPlan& plan_;
    RowStore& store_;
    const PoolOptions options_;
    std::size_t jobs_, total_ = 0;
    std::deque<std::size_t> todo_;     // Rows that this process has not tried yet.
    std::vector<std::size_t> others_;  // That others have claimed.
    std::vector<RowRun> running_;
    std::map<Kind, std::uint64_t> peaks_;      // The most memory that a row of this kind has had.
    std::optional<std::uint64_t> held_bytes_;  // What the first of those that wait still needs.
    std::set<std::size_t> held_;               // Rows that had to wait.
    std::optional<Progress> progress_;
    double begun_, next_refresh_ = 0;
    PoolOutcome outcome_;
    std::size_t failed_ = 0;
};

std::string RowPool::line() const {
    const std::size_t left = todo_.size() + running_.size() + others_.size(), done = total_ - left;
    std::string text = fmt::format("{} of {} runs", grouped(done), grouped(total_));
    if (failed_ > 0) text += fmt::format(", {} failed", grouped(failed_));
    const double seconds = seconds_now() - begun_;
    if (done > 0 && seconds > 0) {
        const double rate = static_cast<double>(done) / seconds;
        text += fmt::format(", {} a second, {} left", format_count(rate), format_duration(static_cast<double>(left) / rate));
    }
    if (!others_.empty()) text += fmt::format(", {} elsewhere", grouped(others_.size()));
    if (held_bytes_)
        text += fmt::format(", {} at a time for want of memory: the next one needs {}", with_memory(), format_bytes(*held_bytes_));
    return text;
}

void RowPool::note_peak(std::size_t row, const RowResult& result) {
    if (!result.fine) return;
    std::uint64_t& peak = peaks_[kind_of(row)];
    peak = std::max(peak, result.memory);
}

std::size_t RowPool::with_memory() const {
    return static_cast<std::size_t>(std::ranges::count_if(running_, [](const RowRun& run) { return run.memory() && !run.waits(); }));
}

// What it will have taken at its peak: that of a row of its kind if there has been one, otherwise what has been computed.
std::uint64_t RowPool::expected_own(const RowRun& run) const {
    const auto seen = peaks_.find(kind_of(run.row()));
    return run.memory()->own_at(seen != peaks_.end() ? seen->second : run.memory()->peak);
}

// Beside those that run, which may grow as well.
bool RowPool::fits(const RowRun& run) const {
    std::uint64_t growth = 0, all = 0;
    for (const RowRun& each : running_) {
        if (!each.memory() || (each.waits() && &each != &run)) continue;
        const std::uint64_t now = each.own_now(), expected = std::max(now, expected_own(each));
        growth += expected - now;
        all += expected;
    }
    if (options_.memory_bytes > 0 && all > options_.memory_bytes) return false;
    const std::uint64_t available = available_memory().bytes;
    return available == 0 || growth <= available;
}

void RowPool::give_memory() {
    held_bytes_.reset();
    for (RowRun& run : running_) {
        if (!run.waits()) continue;
        if (with_memory() > 0 && !fits(run)) {
            held_bytes_ = expected_own(run);
            held_.insert(run.row());
            outcome_.held = held_.size();
            outcome_.held_bytes = std::max(outcome_.held_bytes, *held_bytes_);
            return;
        }
        run.let_go_on();
        outcome_.most_at_once = std::max(outcome_.most_at_once, with_memory());
    }
}

Result<void> RowPool::start_more() {
    // While one waits for memory, no further one has to.
    while (running_.size() < jobs_ && !todo_.empty() && !held_bytes_) {
        const std::size_t row = todo_.front();
        todo_.pop_front();
        if (is_made(row)) continue;
        const Result<bool> mine = store_.claim(plan_.rows()[row]);
        if (!mine) return tl::unexpected<Error>(mine.error());
        if (!*mine) {
            others_.push_back(row);
            continue;
        }
        Result<RowRun> run = RowRun::start(plan_, row);
        if (!run) return tl::unexpected<Error>(run.error());
        running_.push_back(std::move(*run));
    }
    return {};
}

// Waits a little for runs that end.
Result<void> RowPool::collect() {
    std::vector<pollfd> ends;
    for (const RowRun& run : running_) ends.push_back({run.descriptor(), POLLIN, 0});
    poll(ends.data(), ends.size(), kWait_ms);
    for (std::size_t i = ends.size(); i-- > 0;) {
        std::optional<RowResult> result;
        if (ends[i].revents != 0) result = running_[i].take();
        if (!result) result = running_[i].end_if_late(plan_.study().timeout_seconds);
        if (!result) continue;
        const StudyRow& row = plan_.rows()[running_[i].row()];
        note_peak(running_[i].row(), *result);
        running_.erase(running_.begin() + static_cast<std::ptrdiff_t>(i));
        // A signal that has reached the run is no result of it.
        if (result->exit == static_cast<int>(ExitCode::Interrupted)) continue;
        if (auto added = store_.add(row, *result); !added) return added;
        ++outcome_.made;
        if (!failure_of(*result, plan_.study()).empty()) ++failed_;
    }
    give_memory();
    return {};
}

// Rows that others have claimed: made by now, or to be tried again, since their owner may be gone.
void RowPool::look_at_others() {
    const double now = seconds_now();
    if (now < next_refresh_) return;
    store_.refresh();
    next_refresh_ = seconds_now() + std::max(kRefresh_s, (seconds_now() - now) / kRefreshPart);
    if (!todo_.empty()) return;
    for (const std::size_t row : others_)
        if (!is_made(row)) todo_.push_back(row);
    others_.clear();
}

Result<PoolOutcome> RowPool::run() {
    const interrupt::Answering patiently(interrupt::Answer::Patiently);
    while (!todo_.empty() || !running_.empty() || !others_.empty()) {
        if (interrupt::received() != 0) {
            outcome_.interrupted = true;
            break;
        }
        look_at_others();
        if (auto started = start_more(); !started) return tl::unexpected<Error>(started.error());
        if (auto collected = collect(); !collected) return tl::unexpected<Error>(collected.error());
        store_.beat();
        if (progress_) progress_->update([&] { return line(); });
    }
    outcome_.missing = todo_.size() + running_.size() + others_.size();
    running_.clear();
    return outcome_;
}

}  // namespace

Result<PoolOutcome> make_rows(const StudyPlan& plan, RowStore& store, const PoolOptions& options) {
    return RowPool(plan, store, options).run();
}

}  // namespace meld::driver
