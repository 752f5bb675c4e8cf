#include "runtime/driver/session/debug_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "runtime/base/bytes.h"
#include "runtime/base/files/output_file.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/driver/run/checkpoints.h"
#include "runtime/driver/run/run.h"
#include "runtime/driver/run/run_configuration.h"
#include "runtime/driver/setup/command_line.h"
#include "runtime/results/record/state_digest.h"
#include "runtime/results/timeline/history.h"

namespace meld::driver {

namespace {

namespace fs = std::filesystem;

constexpr const char* kEventsFile = "by-hand.toml";

// In a snapshot of the state, as of a run that writes nothing: simulate() adds these two to each.
bool is_part_of_a_run(const std::string& module) { return module == "printer" || module == "watcher"; }

// The same on all processes.
Result<std::string> from_first(comm::Communicator& comm, const Result<std::string>& mine) {
    if (auto all = comm::outcome_of_first(comm, mine.map([](const auto&) {})); !all) return tl::unexpected<Error>(all.error());
    ByteWriter out;
    if (comm.process() == 0) out.write_string(*mine);
    const auto all = comm.allgather_any(out.view());
    return ByteReader(all[0], "what process 0 says").read_string();
}

}  // namespace

// Process 0 compiles.
Result<Module> DebuggedRun::compile(std::string& messages) {
    if (options_.program.ends_with(".so"))
        return fail("reload: the session runs a module, and nobody knows how that was compiled",
                    "Debug the .meld file that it was compiled from");
    const auto mine = [&]() -> Result<std::string> {
        if (comm_.process() != 0) return std::string();
        Result<std::string> path = compile_program(options_, &messages);
        if (path || path.error().code == ExitCode::Interrupted) return path;
        Error error = path.error();
        error.problem = fmt::format("the program is not as it can be run, and the session goes on with the one that it has{}{}",
                                    error.problem.empty() ? "" : ": ", error.problem);
        if (!messages.empty()) error.suggestion = "\n" + messages;
        return tl::unexpected<Error>(std::move(error));
    }();
    const Result<std::string> path = from_first(comm_, mine);
    if (!path) return tl::unexpected<Error>(path.error());
    const Result<std::string> said = from_first(comm_, messages);
    if (!said) return tl::unexpected<Error>(said.error());
    messages = *said;
    Result<Module> module = load_module(*path, kAbiVersion);
    if (auto all = comm::outcome_of_all(comm_, module.map([](const auto&) {})); !all) return tl::unexpected<Error>(all.error());
    return module;
}

Result<debug::Reloaded> DebuggedRun::reload(timeline::Timeline& timeline, const timeline::Timeline::Make& make) {
    debug::Reloaded out{.tick = timeline.tick()};
    // Outlives the simulations of it that are made here.
    Result<Module> module = compile(out.messages);
    if (!module) return tl::unexpected<Error>(module.error());
    if (module->note().checksum == inputs_.module.note().checksum) {
        out.changed = false;
        return out;
    }
    timeline::History now(0);
    sim::Simulation& present = timeline.simulation();
    const ByteWriter counters = present.counters();
    const auto save = [&](sim::ShareSink& sink) { return present.save(counters.view(), sink); };
    if (auto kept = now.keep(out.tick, save, comm_); !kept) return tl::unexpected<Error>(kept.error());

    std::swap(inputs_.module, *module);
    const auto go_on = [&]() -> Result<sim::TakenOver> {
        std::unique_ptr<sim::Simulation> running = make();
        const timeline::GatheredShares shares = timeline::GatheredShares::gather(*now.before(out.tick)->second, comm_);
        Result<sim::TakenOver> facts = running->fork(inputs_.registry, shares, sim::Loads::Anew);
        if (!facts) return facts;
        if (auto begun = timeline.begin_anew(make, std::move(running)); !begun) return tl::unexpected<Error>(begun.error());
        return facts;
    };
    Result<sim::TakenOver> facts = go_on();
    if (!facts) {
        std::swap(inputs_.module, *module);
        Error error = facts.error();
        error.problem = "the session goes on with the program that it has: " + error.problem;
        return tl::unexpected<Error>(std::move(error));
    }
    claims_ = claims(options_, inputs_.module, inputs_.world);
    out.facts = std::move(*facts);
    return out;
}

Result<void> DebuggedRun::can_save() const {
    if (options_.measured())
        return fail("save: the run of this checkpoint counts what its rules do, and the session does not go on counting",
                    "Branch off from the checkpoint by `meldsim fork`");
    return {};
}

// What `meldsim run` would be told to make this run: without results, and with what is still to be done by hand.
Result<DebuggedRun::AsRun> DebuggedRun::as_run(const std::string& folder, const std::string& events) const {
    RunOptions run = options_;
    run.debug.reset();
    run.resume.clear();
    run.fork.clear();
    run.json = run.quiet = false;
    run.world = world_path(options_);
    run.checkpoint = folder;
    const Result<world::World> same = choose_world(run, &inputs_.info());
    if (!same) return tl::unexpected<Error>(same.error());
    if (same->source_hash != inputs_.world.source_hash)
        return fail(fmt::format("save: the world, {}, has changed since the session began", inputs_.world.path), "Put it back");
    AsRun out;
    const world::World* world = &*same;
    Result<world::World> with;
    if (!events.empty()) {
        out.events = (fs::path(folder) / kEventsFile).string();
        std::error_code error;
        if (fs::exists(out.events, error)) return fail(fmt::format("save: {} exists", out.events), "Choose another folder");
        if (auto written = write_file(out.events, events); !written) return tl::unexpected<Error>(written.error());
        run.events.push_back(out.events);
        with = choose_world(run, &inputs_.info());
        if (!with) return tl::unexpected<Error>(with.error());
        world = &*with;
    }
    std::vector<Claim> claims = claims_;
    for (Claim& claim : claims)
        if (claim.name == "the world") claim.hash = world->source_hash;
    run.command = command_line(run);
    out.identity = identity(run, claims, *world);
    return out;
}

Result<debug::Saved> DebuggedRun::save(sim::Simulation& simulation, const std::string& folder, const std::string& events) {
    if (auto can = can_save(); !can) return tl::unexpected<Error>(can.error());
    sim::Subdomain& subdomain = simulation.subdomain();
    Result<sim::CheckpointFolder> into = sim::CheckpointFolder::open(folder, sim::CheckpointFolder::Run::Begins, comm_);
    if (!into) return tl::unexpected<Error>(into.error());
    const Result<AsRun> run = comm_.process() == 0 ? as_run(folder, events) : AsRun{};
    if (auto all = comm::outcome_of_first(comm_, run.map([](const auto&) {})); !all) return tl::unexpected<Error>(all.error());
    debug::Saved out{.tick = subdomain.tick(), .folder = folder, .digest = {}, .events = run->events};
    const ByteWriter counters = simulation.counters();
    const auto save = [&](sim::ShareSink& sink) {
        return simulation.save(counters.view(), sink, [](const std::string& module) { return !is_part_of_a_run(module); });
    };
    const auto digest = [&] { return out.digest = record::state_digest(subdomain).to_string(); };
    if (auto written = into->write({.tick = out.tick, .digest = "", .run = run->identity, .shares = {}}, save, digest, comm_); !written) {
        std::error_code ignored;
        if (!out.events.empty()) fs::remove(out.events, ignored);
        return tl::unexpected<Error>(written.error());
    }
    return out;
}

}  // namespace meld::driver
