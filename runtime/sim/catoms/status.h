// The state of a run between two ticks: the outcome of the last tick on all processes, and what only this process knows about it.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/engine/eval/evaluator.h"
#include "runtime/world/lattice/lattice.h"

namespace meld::sim {

// The sums of what all processes report to each other at the end of a tick.
struct Totals {
    eval::Statistics tick;  // Of this tick.
    std::uint64_t catoms = 0;
    std::uint64_t bytes = 0;
    std::uint64_t actions = 0;
    std::uint64_t creations_requested = 0;  // `create` actions among them.
    std::uint64_t teleports = 0;            // `moveTo` actions among them.
    std::uint64_t sent_bytes = 0;           // Between processes.
    std::uint64_t lost = 0;                 // Linear facts of catoms that were killed or have restarted.
    std::uint64_t links_cut = 0, links_made = 0;
    std::uint64_t nodes_made = 0;  // By rules.
    bool awake = false;            // Something is left to do: an agenda, a message, an action.
    bool waiting = false;          // Something happens later: a timer or an event of the world.
    bool timers = false;           // A timer is set.
    bool quarantines = false;      // Under a clock that gives turns: what groups have lost is not trusted again yet.
    bool rested = false;           // Under such a clock: from the next tick on it is.
    bool undefined = false;        // Some view has an undefined derivation.
    bool stop = false;             // Somebody outside asked for the end.
    bool save = false;             // Somebody outside asked for a checkpoint after this tick.
    bool finished = false;         // A catom did, with `stop-program`.
    std::uint32_t greatest_rank = 0;
    eval::Failure failure;
    // Nothing is left to do until the world changes: the views are the model of the facts that are given and sensed now.
    bool quiescent() const { return !awake && !timers; }

    // Adds those of another process. Of two failures, that of the lower catom is kept.
    void add(const Totals& other);
};

// A catom that has been killed, and whose neighbours do not sense it yet.
struct Dying {
    std::int64_t tick = 0;  // In which they do.
    std::uint64_t id = 0;
    world::Cell cell = {};  // On a lattice.
};

class Status {
  public:
    // The last tick that ended well.
    std::int64_t last_tick() const { return last_tick_; }
    // Facts, or the links that they depend on, have changed since, in a tick that has not ended.
    bool half_way() const { return half_way_; }
    void note_change() { half_way_ = true; }
    // A catom whose rules trap stops halfway; the other catoms do not.
    void end_tick(std::int64_t tick, bool well);
    // After an error in a tick: what is true on any process becomes true on all.
    void end_early(bool half_way_anywhere) { half_way_ = half_way_anywhere; }

    Totals totals;
    // Something moves by itself, so the run continues although no program has anything to do.
    bool moving = false;
    // The run is to end at this tick boundary; set from a signal handler or a module.
    bool stop_requested = false;
    // It ends with the tick that has just been; the same on all processes.
    bool ends_here = false;

    // By their numbers, ascending; the same on all processes.
    std::vector<std::uint64_t> hung;
    // In the order of ticks; of one tick, by their numbers. They hang until then.
    std::vector<Dying> dying;
    // In this tick, on this process.
    std::uint64_t lost = 0, links_cut = 0, links_made = 0, nodes_made = 0;

    // A checkpoint is to be made at a tick boundary that all processes agree on; whoever makes it takes the request back.
    bool save_requested = false;

    // As after this tick, of a run that goes on from a snapshot.
    void resume(std::int64_t tick, const Totals& of_the_tick) {
        last_tick_ = tick;
        totals = of_the_tick;
    }

  private:
    std::int64_t last_tick_ = 0;
    bool half_way_ = false;
};

}  // namespace meld::sim
