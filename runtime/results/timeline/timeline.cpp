#include "runtime/results/timeline/timeline.h"

#include <fmt/format.h>

#include <utility>

#include "runtime/base/assert.h"
#include "runtime/results/record/state_digest.h"

namespace meld::timeline {

Result<void> Timeline::start(const sim::Shares* from) {
    MELD_EXPECT(present_ == nullptr, "a timeline is started once");
    from_ = from;
    Result<Running> begun = from_the_start();
    if (!begun) return tl::unexpected<Error>(begun.error());
    present_ = std::move(*begun);
    if (options_.history_bytes > 0)
        if (auto can = present_->saveable(); !can) return can;
    first_tick_ = latest_ = tick();
    return check(*present_);
}

Result<Timeline::Running> Timeline::from_the_start() {
    if (beginning_) return restore_from(*beginning_->before(first_tick_)->second);
    Running running = make_();
    const Result<void> done = from_ != nullptr ? running->resume(registry_, *from_) : running->start(registry_);
    if (!done) return tl::unexpected<Error>(done.error());
    return running;
}

Result<void> Timeline::check(sim::Simulation& simulation) {
    sim::Subdomain& subdomain = simulation.subdomain();
    const Digest now = record::state_digest(subdomain);
    const auto [seen, is_new] = digests_.try_emplace(subdomain.tick(), now);
    if (is_new || seen->second == now) return {};
    return fail(fmt::format("tick {} is not what it was: its digest is {} now, and was {}", subdomain.tick(), now.to_string(),
                            seen->second.to_string()),
                "Please report this with the program and the world", ExitCode::OurBug);
}

// Takes a snapshot if it is time.
Result<void> Timeline::remember(sim::Simulation& simulation) {
    if (options_.history_bytes == 0) return {};
    const sim::Subdomain& subdomain = simulation.subdomain();
    const std::int64_t tick = subdomain.tick();
    const auto last = history_.before(tick);
    // The totals are those of all processes, so all decide alike. A body takes part in every tick.
    work_since_ += subdomain.totals.tick.awake + (subdomain.ensemble.is_free() ? subdomain.totals.catoms : 0);
    const bool enough = work_since_ >= subdomain.totals.catoms && work_since_ > 0;
    if (!enough && tick - (last ? last->first : first_tick_) < options_.most_ticks_between) return {};
    work_since_ = 0;
    if (history_.has(tick)) return {};
    const ByteWriter counters = simulation.counters();
    return history_.keep(tick, [&](sim::ShareSink& sink) { return simulation.save(counters.view(), sink); }, subdomain.comm);
}

// The latest state that is known at or before a tick.
Result<Timeline::Running> Timeline::restore(std::int64_t tick) {
    const auto kept = history_.before(tick);
    return kept ? restore_from(*kept->second) : from_the_start();
}

Result<Timeline::Running> Timeline::restore_from(const KeptShare& kept) {
    Running running = make_();
    const GatheredShares shares = GatheredShares::gather(kept, running->subdomain().comm);
    if (auto done = running->resume(registry_, shares); !done) return tl::unexpected<Error>(done.error());
    return running;
}

Result<void> Timeline::begin_anew(Make make, std::unique_ptr<sim::Simulation> running) {
    if (auto can = running->saveable(); !can) return can;
    // The newest snapshot is kept, however large it is.
    History beginning(0);
    sim::Subdomain& subdomain = running->subdomain();
    const ByteWriter counters = running->counters();
    const auto save = [&](sim::ShareSink& sink) { return running->save(counters.view(), sink); };
    if (auto kept = beginning.keep(subdomain.tick(), save, subdomain.comm); !kept) return kept;
    make_ = std::move(make);
    from_ = nullptr;
    beginning_ = std::move(beginning);
    history_ = History(options_.history_bytes);
    present_ = std::move(running);
    ++replaced_;
    first_tick_ = latest_ = tick();
    work_since_ = 0;
    digests_.clear();
    failure_.reset();
    return check(*present_);
}

Result<void> Timeline::run_to(sim::Simulation& simulation, std::int64_t tick, const Stop& stop) {
    sim::Subdomain& subdomain = simulation.subdomain();
    subdomain.take_back_stop();
    while (subdomain.tick() < tick && !simulation.ended(options_.limits)) {
        if (failure_ && failure_->first == subdomain.tick() + 1) return tl::unexpected<Error>(failure_->second);
        if (each_) each_(simulation);
        if (auto done = simulation.step(options_.limits); !done) {
            if (done.error().code != ExitCode::Interrupted) failure_ = {subdomain.tick(), done.error()};
            return done;
        }
        const bool is_new = subdomain.tick() > latest_;
        if (is_new) latest_ = subdomain.tick();
        if (options_.check == TimelineOptions::Check::EveryTick)
            if (auto same = check(simulation); !same) return same;
        if (is_new && each_new_)
            if (auto done = each_new_(simulation); !done) return done;
        if (auto kept = remember(simulation); !kept) return kept;
        if (!stop) continue;
        const Result<bool> here = stop(simulation);
        if (!here) return tl::unexpected<Error>(here.error());
        if (*here) break;
    }
    return check(simulation);
}

Result<Timeline::Running> Timeline::beside(std::int64_t tick) {
    if (tick < first_tick_) return fail(fmt::format("tick {} is before the first, {}", tick, first_tick_), "", ExitCode::UsageOrWorld);
    Result<Running> running = restore(tick);
    if (!running) return running;
    const std::uint64_t work = std::exchange(work_since_, 0);
    const Result<void> done = run_to(**running, tick);
    work_since_ = work;
    if (!done) return tl::unexpected<Error>(done.error());
    return running;
}

Result<void> Timeline::run_apart(sim::Simulation& simulation, std::int64_t tick) {
    // How many ticks the run was to have does not matter here.
    const sim::RunLimits limits{.strict = options_.limits.strict};
    while (simulation.subdomain().tick() < tick && !simulation.ended(limits)) {
        if (each_) each_(simulation);
        if (auto done = simulation.step(limits); !done) return done;
    }
    if (simulation.subdomain().totals.stop) return fail("interrupted before there was an answer", "", ExitCode::Interrupted);
    return {};
}

Result<void> Timeline::walk(std::int64_t from, std::int64_t to, const std::function<Result<bool>(sim::Simulation&)>& visit) {
    Result<Running> running = beside(from);
    if (!running) return tl::unexpected<Error>(running.error());
    sim::Simulation& simulation = **running;
    while (true) {
        if (simulation.subdomain().totals.stop) return fail("interrupted before there was an answer", "", ExitCode::Interrupted);
        const Result<bool> more = visit(simulation);
        if (!more) return tl::unexpected<Error>(more.error());
        if (!*more || simulation.subdomain().tick() >= to || simulation.ended(options_.limits)) return {};
        if (each_) each_(simulation);
        if (auto done = simulation.step(options_.limits); !done) return done;
    }
}

Result<void> Timeline::to(std::int64_t tick) {
    const std::int64_t now = this->tick();
    const auto kept = history_.before(tick);
    // A snapshot between here and there is nearer.
    if (tick >= now && !(kept && kept->first > now)) return forward_until(tick, {});
    Result<Running> there = beside(tick);
    if (!there) return tl::unexpected<Error>(there.error());
    present_ = std::move(*there);
    ++replaced_;
    work_since_ = 0;
    return {};
}

void Timeline::changes_from_here() {
    latest_ = tick();
    history_.forget_after(latest_);
    digests_.erase(digests_.upper_bound(latest_), digests_.end());
    if (failure_ && failure_->first > latest_) failure_.reset();
    present_->subdomain().expect_event();
}

Result<void> Timeline::forward_until(std::int64_t tick, const Stop& stop) {
    const std::int64_t now = this->tick();
    Result<void> done = run_to(*present_, tick, stop);
    if (done || present_->subdomain().tick() == now) return done;
    // What fails leaves the middle of a tick behind.
    Result<Running> again = beside(now);
    if (!again) return tl::unexpected<Error>(again.error());
    present_ = std::move(*again);
    ++replaced_;
    return done;
}

std::optional<Digest> Timeline::digest(std::int64_t tick) const {
    const auto seen = digests_.find(tick);
    return seen == digests_.end() ? std::nullopt : std::optional(seen->second);
}

}  // namespace meld::timeline
