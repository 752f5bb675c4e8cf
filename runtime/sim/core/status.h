// How a run stands between two ticks: what the last tick came to everywhere, and what this process alone knows of it.
#pragma once

#include <cstdint>

#include "runtime/eval/evaluator.h"

namespace meld::sim {

// What all processes report to each other at the end of a tick, summed up.
struct Totals {
    eval::Statistics tick;  // Of this tick.
    std::uint64_t catoms = 0;
    std::uint64_t bytes = 0;
    std::uint64_t actions = 0;
    std::uint64_t creations_requested = 0;  // `create` actions among them.
    std::uint64_t teleports = 0;            // `moveTo` actions among them.
    std::uint64_t sent_bytes = 0;           // Between processes.
    bool awake = false;                     // Something is left to do: an agenda, a message, an action.
    bool waiting = false;                   // Something comes later: a timer or an event of the world.
    bool timers = false;                    // A timer does.
    bool undefined = false;                 // Some view has an undefined derivation.
    bool stop = false;                      // Somebody outside asked for the end.
    bool finished = false;                  // A catom did, with `stop-program`.
    std::uint32_t greatest_rank = 0;
    eval::Failure failure;
    // Nothing is left to do until the world changes: the views are the model of what is given and sensed now.
    bool quiescent() const { return !awake && !timers; }

    // Adds those of another process. Of two failures the one at the lesser catom stays.
    void add(const Totals& other);
};

class Status {
  public:
    // The last tick that ended well.
    std::int64_t last_tick() const { return last_tick_; }
    // Facts, or the links that they stand on, have changed since, and the tick in which they did has not ended.
    bool half_way() const { return half_way_; }
    void note_change() { half_way_ = true; }
    // A catom whose rules trap stops in their midst, and the others do not.
    void end_tick(std::int64_t tick, bool well);
    // After an error in a tick: what holds on any process holds on all.
    void end_early(bool half_way_anywhere) { half_way_ = half_way_anywhere; }

    Totals totals;
    // Something moves by itself, so the run goes on though no program has anything to do.
    bool moving = false;
    // The run is to end at this tick boundary; set from a signal handler or a module.
    bool stop_requested = false;

  private:
    std::int64_t last_tick_ = 0;
    bool half_way_ = false;
};

}  // namespace meld::sim
