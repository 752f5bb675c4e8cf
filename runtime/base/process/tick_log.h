// Where the wall-clock time of a run's ticks goes on one process: the stages of each tick, and how long each worker was busy with catoms.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/base/process/stage_clock.h"

namespace meld {

class TickLog {
  public:
    // In the order of a tick; Between: after it, until the next.
    enum class Stage : std::uint8_t { Motion, Components, Events, Code, Evaluation, Commit, Exchange, Agreement, Recording, Between };
    static constexpr std::size_t kStages = 10;
    static const char* name(Stage stage);

    // One tick, or several in a row: then the times are sums.
    struct Span {
        std::int64_t first = 0, last = 0;
        double begin = 0;  // Seconds since the log was made.
        std::array<double, kStages> seconds = {};
        std::vector<double> busy;  // By worker.
    };

    explicit TickLog(int threads) : busy_(static_cast<std::size_t>(threads)), start_(seconds_now()), entered_(start_) {}

    void begin_tick(std::int64_t tick);
    // Ends the stage before. Cost: one reading of the clock.
    void enter(Stage stage);
    // A worker has been busy with catoms for so long. From the workers at once; between two calls of enter().
    void add_busy(int worker, double seconds) { busy_[static_cast<std::size_t>(worker)].seconds += seconds; }
    // The run is over.
    void end() { enter(Stage::Between); }

    // At most kMostSpans, which cover all ticks.
    const std::vector<Span>& spans() const { return spans_; }

  private:
    static constexpr std::size_t kMostSpans = 4096;
    struct alignas(64) Busy {
        double seconds = 0;
    };
    void halve();

    std::vector<Busy> busy_;  // Since the last call of enter().
    double start_, entered_;
    Stage stage_ = Stage::Between;
    std::int64_t ticks_of_a_span_ = 1;
    std::vector<Span> spans_;
};

inline void enter(TickLog* log, TickLog::Stage stage) {
    if (log != nullptr) log->enter(stage);
}

}  // namespace meld
