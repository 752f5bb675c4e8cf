// A run as all of its ticks: the state at any of them, by going forward, and back to a snapshot and forward from there. That it is the
// same run each time is checked by digests.
//
// All processes of the run have one and call it at the same time, with the same ticks. Nothing is written or printed by it: what a run
// writes is made by modules, and `make` adds only those that may see a tick several times.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "runtime/base/error.h"
#include "runtime/base/hash.h"
#include "runtime/results/timeline/history.h"
#include "runtime/sim/simulation.h"

namespace meld::timeline {

struct TimelineOptions {
    sim::RunLimits limits = {};
    // Memory for snapshots, of each process. 0: none are kept, and every way back is from the start.
    std::size_t history_bytes = std::size_t{1} << 30;
    // A snapshot is taken at least so often, and sooner if so many catoms have been evaluated that to do it again takes as long as to
    // restore a snapshot.
    std::int64_t most_ticks_between = 64;
    // A digest costs a look at all facts.
    enum class Check { WhereItStops, EveryTick } check = Check::WhereItStops;
};

class Timeline {
  public:
    // A simulation of the run that has not been started, with the modules that it needs.
    using Make = std::function<std::unique_ptr<sim::Simulation>()>;
    Timeline(Make make, const sim::Registry& registry, TimelineOptions options = {})
        : make_(std::move(make)), registry_(registry), options_(options), history_(options.history_bytes) {}

    // Begins at the world as it is before the first tick, or at a snapshot, before which nothing can be seen; it must outlive this. Errors:
    // those of Simulation; the run cannot be saved, and there is a history.
    Result<void> start(const sim::Shares* from = nullptr);

    // From here on it is another run, whose simulations `make` makes. `running` is at its beginning, between two ticks; what was before
    // that cannot be seen any more. Errors: it cannot be saved, and then this timeline stays what it was. Cost: a snapshot, beside the
    // history.
    Result<void> begin_anew(Make make, std::unique_ptr<sim::Simulation> running);

    // The run as it is at tick(). Valid until the next call that moves it back.
    sim::Simulation& simulation() { return *present_; }
    // How often that has become another one: whoever keeps something of it looks at all of it again then.
    std::uint64_t replaced() const { return replaced_; }
    std::int64_t tick() { return present_->subdomain().tick(); }
    std::int64_t first_tick() const { return first_tick_; }
    // How the run ends at this tick, if it does.
    std::optional<sim::Ending> ended() const { return present_->ended(options_.limits); }

    // Goes to a tick, or to the last one of the run if it has fewer; tick() says which. Errors: the program fails on the way, and the
    // timeline stays where it was; the tick is before the first; a digest differs from the one seen before (70).
    // Cost: forward, the run. Back, a simulation from a snapshot, which is some 100 ns a catom of this process and, with several
    // processes, one exchange of all of it; the ticks since, at most `most_ticks_between` where the history has not been thinned; and a
    // digest.
    Result<void> to(std::int64_t tick);
    // Goes forward as to() does, tick by tick, and no further than a tick after which `stop` says so, of the state then; the same on every
    // process. Errors: also those of `stop`.
    using Stop = std::function<Result<bool>(sim::Simulation&)>;
    Result<void> forward_until(std::int64_t tick, const Stop& stop);
    Result<void> back(std::int64_t ticks = 1) { return to(tick() - ticks); }
    Result<void> forward(std::int64_t ticks = 1) { return to(tick() + ticks); }

    // The state at a tick as a run of its own, beside this one, which stays where it is. Errors and cost: as of to().
    Result<std::unique_ptr<sim::Simulation>> beside(std::int64_t tick);

    // Runs a state from beside() on to this tick, or to where it ends before, as a run of its own: nothing of it is kept or compared, so
    // the world may say something else meanwhile. Errors: the program fails; a signal has asked for the end.
    Result<void> run_apart(sim::Simulation& simulation, std::int64_t tick);

    // The states of these ticks one after the other, as a run beside this one, until `visit` says false or the run ends. Errors and cost:
    // as of beside() for the first; and the ticks.
    Result<void> walk(std::int64_t from, std::int64_t to, const std::function<Result<bool>(sim::Simulation&)>& visit);

    // The world has got events after this tick, so what was known of later ones is not what they will be.
    void changes_from_here();

    // The digest of a tick at which it has stopped, or that it has seen if it checks every tick.
    std::optional<Digest> digest(std::int64_t tick) const;
    // Called before every tick, also of one that is run again. It shows how far the run is, and may ask it to stop (request_stop()): then
    // to() ends after that tick, and ended() says Interrupted until the next to().
    void each(std::function<void(sim::Simulation&)> call) { each_ = std::move(call); }
    // Called after every tick that is run for the first time.
    void each_new(std::function<Result<void>(sim::Simulation&)> call) { each_new_ = std::move(call); }
    const History& history() const { return history_; }

  private:
    using Running = std::unique_ptr<sim::Simulation>;
    Result<Running> restore(std::int64_t tick);
    Result<Running> restore_from(const KeptShare& kept);
    Result<Running> from_the_start();
    Result<void> run_to(sim::Simulation& simulation, std::int64_t tick, const Stop& stop = {});
    Result<void> remember(sim::Simulation& simulation);
    Result<void> check(sim::Simulation& simulation);

    Make make_;
    const sim::Registry& registry_;
    TimelineOptions options_;
    History history_;
    const sim::Shares* from_ = nullptr;
    std::optional<History> beginning_;  // Instead: one snapshot, of its first tick.
    Running present_;
    std::uint64_t replaced_ = 0;
    std::int64_t first_tick_ = 0;
    std::int64_t latest_ = 0;       // The last tick that was run.
    std::uint64_t work_since_ = 0;  // Evaluations since the last snapshot.
    std::map<std::int64_t, Digest> digests_;
    std::optional<std::pair<std::int64_t, Error>> failure_;  // Of the tick in which the program fails.
    std::function<void(sim::Simulation&)> each_;
    std::function<Result<void>(sim::Simulation&)> each_new_;
};

}  // namespace meld::timeline
