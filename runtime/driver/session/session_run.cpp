#include "runtime/driver/session/session_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/terminal/log.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/driver/run/checkpoints.h"
#include "runtime/driver/run/replay.h"
#include "runtime/driver/run/replay_without_outputs.h"
#include "runtime/results/timeline/history.h"
#include "runtime/sim/watchers/watcher.h"

namespace meld::driver {

namespace {

// Whether the run of the checkpoint was recorded, or there is none: what catoms have drawn is known.
bool knows_drawing(const RunOptions& options) {
    const std::vector<std::string>& writers = options.debug->writers;
    return options.resume.empty() || std::ranges::find(writers, "recorder") != writers.end();
}

}  // namespace

Result<std::unique_ptr<sim::OpenCheckpoint>> open_beginning(const RunOptions& options, const std::vector<Claim>& claims,
                                                            const world::World& world, comm::Communicator& comm,
                                                            std::optional<std::int64_t> before) {
    if (options.resume.empty()) return nullptr;
    Result<sim::OpenCheckpoint> newest = sim::open_newest(options.resume, comm, before);
    if (!newest) return tl::unexpected<Error>(newest.error());
    const sim::Checkpoint& checkpoint = newest->checkpoint;
    if (!checkpoint.passed_over.empty() && comm.process() == 0)
        log::warning("a newer checkpoint is not whole, and the session begins with that of tick {}: {}", checkpoint.manifest.tick,
                     checkpoint.passed_over);
    Result<void> same;
    if (const std::string other = sim::difference(checkpoint.manifest.run, identity(options, claims, world)); !other.empty())
        same = fail(fmt::format("the run in {} cannot be looked at: {}", options.resume, other), "Put back what it was started with",
                    ExitCode::RecordingRefused);
    if (const auto all = comm::outcome_of_all(comm, same); !all) return tl::unexpected<Error>(all.error());
    return std::make_unique<sim::OpenCheckpoint>(std::move(*newest));
}

Result<std::unique_ptr<timeline::Timeline>> start_timeline(const RunOptions& options, const Inputs& inputs, timeline::Timeline::Make make,
                                                           const sim::OpenCheckpoint* from, std::size_t history_bytes) {
    const timeline::TimelineOptions how{.limits = {options.ticks, options.strict}, .history_bytes = history_bytes};
    auto timeline = std::make_unique<timeline::Timeline>(std::move(make), inputs.registry, how);
    if (auto done = timeline->start(from != nullptr ? &from->shares : nullptr); !done) return tl::unexpected<Error>(done.error());
    if (from != nullptr && timeline->digest(timeline->tick())->to_string() != from->checkpoint.manifest.digest)
        return fail(
            fmt::format("the checkpoint of tick {} in {} does not give back its state", from->checkpoint.manifest.tick, options.resume),
            "Please report this with the program and the world", ExitCode::OurBug);
    return timeline;
}

record::Drawing& Drawings::of(timeline::Timeline& timeline) {
    const sim::Simulation* const present = &timeline.simulation();
    // The others are gone, or made for an answer that has been given.
    std::erase_if(of_, [&](const auto& entry) { return entry.first != present; });
    MELD_CHECK(of_.size() == 1, "a run that nobody has followed, after tick {}", timeline.tick());
    return *of_.begin()->second;
}

Result<timeline::Timeline::Make> make_simulations(const RunOptions& options, Inputs& inputs, comm::Communicator& comm, Drawings* drawings) {
    MakeModule check;
    if (!options.replay.empty()) {
        Result<MakeModule> made = make_check(options.replay);
        if (const auto all = comm::outcome_of_all(comm, made.map([](const auto&) {})); !all) return tl::unexpected<Error>(all.error());
        check = std::move(*made);
    }
    std::vector<std::string> writers = options.debug->writers;
    // A run from its start has these.
    if (options.resume.empty() && options.replay.empty() && !options.debug->inquiry) writers = {"printer", "watcher"};
    return [&options, &inputs, &comm, drawings, check, writers] {
        auto simulation = std::make_unique<sim::Simulation>(inputs.info(), inputs.world, inputs.target, comm, options.threads);
        if (check) simulation->add(check(), "check");
        const bool draws = drawings != nullptr && knows_drawing(options);
        if (draws) {
            auto follows = std::make_unique<record::Drawing>();
            drawings->note(*simulation, *follows);
            simulation->add(std::move(follows), "recorder");
        }
        for (const std::string& name : writers) {
            // What is watched is known to a run that goes on from here.
            if (name == "watcher")
                simulation->add(std::make_unique<sim::Watcher>(nullptr), name);
            else if (!draws || name != "recorder")
                simulation->add(std::make_unique<Silent>(), name);
        }
        return simulation;
    };
}

Result<timeline::Timeline::Make> begin_drawing(const RunOptions& options, const Inputs& inputs, comm::Communicator& comm,
                                               timeline::Timeline& timeline, timeline::Timeline::Make make, Drawings& drawings) {
    if (knows_drawing(options)) return make;
    timeline::Timeline::Make with = [make = std::move(make), &drawings] {
        std::unique_ptr<sim::Simulation> simulation = make();
        auto follows = std::make_unique<record::Drawing>();
        drawings.note(*simulation, *follows);
        simulation->add(std::move(follows), "drawing");
        return simulation;
    };
    timeline::History now(0);
    sim::Simulation& present = timeline.simulation();
    const ByteWriter counters = present.counters();
    const auto save = [&](sim::ShareSink& sink) { return present.save(counters.view(), sink); };
    if (auto kept = now.keep(timeline.tick(), save, comm); !kept) return tl::unexpected<Error>(kept.error());
    std::unique_ptr<sim::Simulation> running = with();
    const timeline::GatheredShares shares = timeline::GatheredShares::gather(*now.before(timeline.tick())->second, comm);
    if (auto done = running->fork(inputs.registry, shares, sim::Loads::BranchesOff); !done) return tl::unexpected<Error>(done.error());
    if (auto begun = timeline.begin_anew(with, std::move(running)); !begun) return tl::unexpected<Error>(begun.error());
    return with;
}

}  // namespace meld::driver
