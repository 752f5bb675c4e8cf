// What somebody does to a run by hand, between two ticks: each becomes an event of its world, in the next tick.
//
// So it happens again whenever that tick is run again, and a world with the same events makes the same run. A run that is changed in the
// past has another future: what was done by hand after that is dropped.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "runtime/ask/debug/answer.h"
#include "runtime/ask/debug/command.h"
#include "runtime/base/error.h"
#include "runtime/results/timeline/timeline.h"
#include "runtime/world/description/world.h"

namespace meld::debug {

// One fact, as a world gives or takes it at its catom.
struct OneFact {
    std::string text = {};  // As Meld writes it.
    std::uint64_t catom = 0;
    world::GivenFact given = {};
};

// Reads a fact without variables; a full stop may end it. `verb`: what somebody wants to do, for messages. Every process calls it. Errors:
// mistakes in the fact; a world could not give it; there is no such catom.
Result<OneFact> read_fact(sim::Subdomain& subdomain, std::string fact, const char* verb);

// The same of a fact that is to be taken: it is one of those that are given, or linear, and holds.
Result<OneFact> read_given_fact(sim::Subdomain& subdomain, std::string fact, const char* verb);

// Every process has one and calls all of this at the same time.
class ByHand {
  public:
    // The world of the timeline, which outlives this.
    explicit ByHand(world::World& world) : world_(world), own_events_(world.events.size()) {}

    // Errors: mistakes in the fact; the world could not give it; there is no such catom; what is to be taken does not hold or is not
    // given.
    Result<Answer> change(timeline::Timeline& timeline, const Change& asked);
    // Errors: there is no such catom; mistakes in the body; it is about no catom, or holds for none; what hangs or restarts needs links.
    Result<Answer> kill(timeline::Timeline& timeline, const Kill& asked);
    // Errors: those of kill; nobody knows links; jams would last longer than the world says.
    Result<Answer> strike_links(timeline::Timeline& timeline, const StrikeLinks& asked);
    EventsFound all(std::int64_t tick) const;
    // The run begins anew at a tick: what was done before it does not happen again. Returns the number of those that did not happen before
    // that call, for happens_from(), which takes it back.
    std::size_t happens_after(std::int64_t tick);
    void happens_from(std::size_t first);
    // What happens after a tick, as [[event]] tables; empty if nothing does.
    std::string to_come(std::int64_t tick) const;
    // As [[event]] tables of a world; on process 0. Errors, the same on every process: those of the file.
    Result<Answer> write(const std::string& path, comm::Communicator& comm) const;

    // All that was done, for a branch of the run.
    struct Done {
        EventsFound::One shown;
        world::Event event;
        std::string toml = {};  // What the table of the event says after its tick.
    };
    struct State {
        std::vector<Done> done = {};
        std::size_t first = 0;  // Those before it do not happen in this run.
    };
    const State& state() const { return state_; }
    // The first tick in which another branch of this run is another one; nothing: both are the same.
    std::optional<std::int64_t> parts_from(const State& other) const;
    void restore(State state);

  private:
    Result<void> may_jam(const world::Event& event) const;
    Result<Answer> add(timeline::Timeline& timeline, Done done);
    void give_to_world();
    std::string as_toml(std::int64_t after) const;

    world::World& world_;
    std::size_t own_events_;  // Those of the world itself come first.
    State state_;
};

}  // namespace meld::debug
