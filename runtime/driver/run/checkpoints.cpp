#include "runtime/driver/run/checkpoints.h"

#include <fmt/format.h>

#include <charconv>
#include <filesystem>
#include <utility>

#include "runtime/base/process/interrupt.h"
#include "runtime/base/process/liveness.h"
#include "runtime/base/terminal/log.h"
#include "runtime/base/units.h"
#include "runtime/driver/setup/made_by.h"
#include "runtime/driver/study/run_counts.h"
#include "runtime/results/record/state_digest.h"
#include "runtime/sim/state/share_file.h"

namespace meld::driver {

Result<Interval> parse_interval(std::string_view text) {
    const auto wrong = [&] {
        return fail(fmt::format("--checkpoint-every: '{}' is no interval", text), "Write a time such as 10min, or 1000ticks");
    };
    Interval every;
    for (const std::string_view unit : {"ticks", "tick"}) {
        if (!text.ends_with(unit)) continue;
        const std::string_view number = text.substr(0, text.size() - unit.size());
        const char* const end = number.data() + number.size();
        const auto read = std::from_chars(number.data(), end, every.ticks);
        if (read.ec != std::errc{} || read.ptr != end || every.ticks < 1) return wrong();
        return every;
    }
    const Result<double> seconds = parse_duration(text);
    if (!seconds || !(*seconds > 0)) return wrong();
    every.seconds = *seconds;
    return every;
}

sim::RunIdentity identity(const RunOptions& options, const std::vector<Claim>& claims, const world::World& world) {
    sim::RunIdentity run{
        .traits = {}, .world = world.parts, .folder = std::filesystem::current_path().string(), .command = options.command};
    for (const Claim& claim : claims)
        if (claim.what_it_is) run.traits.push_back({claim.name, claim.shown, claim.hash});
    return run;
}

Result<void> Checkpoints::resume(const sim::Registry& registry) {
    comm::Communicator& comm = simulation_.subdomain().comm;
    const Result<sim::OpenCheckpoint> newest = folder_.newest(comm);
    if (!newest) return tl::unexpected<Error>(newest.error());
    const sim::Checkpoint* const checkpoint = &newest->checkpoint;
    if (!checkpoint->passed_over.empty() && comm.process() == 0)
        log::warning("a newer checkpoint is not whole, and the run goes on from that of tick {}: {}", checkpoint->manifest.tick,
                     checkpoint->passed_over);
    if (const std::string other = difference(checkpoint->manifest.run, run_); !other.empty())
        return fail(fmt::format("the run in {} cannot go on: {}", folder_.path(), other),
                    "Put back what it was started with, or start a new run", ExitCode::RecordingRefused);
    if (auto done = simulation_.resume(registry, newest->shares); !done) return done;
    // Whatever went wrong with it shows here, and not in results.
    if (const Digest now = record::state_digest(simulation_.subdomain()); now.to_string() != checkpoint->manifest.digest)
        return fail(fmt::format("the checkpoint of tick {} in {} does not give back its state", checkpoint->manifest.tick, folder_.path()),
                    "Please report this with the program and the world", ExitCode::OurBug);
    return {};
}

void Checkpoints::after_tick() {
    sim::Subdomain& subdomain = simulation_.subdomain();
    // at_end() comes, or there is nothing whole to save.
    if (subdomain.totals.stop || subdomain.status().half_way()) return;
    if (every_.ticks > 0 ? subdomain.tick() % every_.ticks == 0 : subdomain.totals.save) return write();
    if (every_.ticks > 0 || subdomain.comm.process() != 0) return;
    const std::chrono::duration<double> since = std::chrono::steady_clock::now() - last_try_;
    subdomain.request_save(since.count() >= every_.seconds);
}

void Checkpoints::at_end() {
    const sim::Subdomain& subdomain = simulation_.subdomain();
    if (subdomain.tick() > 0 && folder_.last() != subdomain.tick() && !subdomain.status().half_way()) write();
}

void Checkpoints::write() {
    sim::Subdomain& subdomain = simulation_.subdomain();
    const interrupt::Answering patiently(interrupt::Answer::Patiently);
    liveness::enter(liveness::Phase::Checkpoint);
    const ByteWriter counters = simulation_.counters();
    if (folder_.stores_changes() && !subdomain.ensemble.is_free() && !changed_) changed_.emplace(subdomain);
    sim::ChangedChunks* const changed = changed_ ? &*changed_ : nullptr;
    if (changed != nullptr) changed->look();
    const auto save = [&](sim::ShareSink& sink) {
        return changed != nullptr ? simulation_.save_changes(counters.view(), sink, *changed) : simulation_.save(counters.view(), sink);
    };
    const auto digest = [&] {
        return (changed != nullptr ? digest_.of(subdomain, *changed) : record::state_digest(subdomain)).to_string();
    };
    Result<void> written = simulation_.secure();
    if (written)
        written = folder_.write({.tick = subdomain.tick(),
                                 .digest = "",
                                 .run = run_,
                                 .shares = {},
                                 .made_by = made_by().dump(),
                                 .counts = counts_of(simulation_.summary()).dump()},
                                save, digest, subdomain.comm);
    if (written && changed != nullptr) changed->saved();
    if (!written && subdomain.comm.process() == 0)
        log::warning("no checkpoint of tick {}: {}. The run goes on{}", subdomain.tick(), written.error().message(),
                     folder_.last() ? fmt::format("; the last checkpoint is of tick {}", *folder_.last()) : "");
    subdomain.request_save(false);
    last_try_ = std::chrono::steady_clock::now();
}

std::string Checkpoints::status() const { return folder_.last() ? fmt::format("checkpoint of tick {}", *folder_.last()) : ""; }

}  // namespace meld::driver
