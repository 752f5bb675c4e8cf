#include "tests/reference/trials/disturbance.h"

#include <stdexcept>

#include "runtime/base/random.h"
#include "runtime/sim/core/code_modules.h"
#include "runtime/sim/state/loader.h"
#include "runtime/sim/state/saver.h"

namespace meld::reference {

namespace {

// More often no run is disturbed, so that each comes to its end.
constexpr std::uint64_t kAttempts = 4;

void check(const Result<void>& done) {
    if (!done) throw std::runtime_error(done.error().message());
}

}  // namespace

std::uint64_t Disturbance::draw(std::uint64_t below) { return random_bits(seed_, 0x64697374, ++draws_, 0) % below; }

bool Disturbance::attempt(const std::function<void(comm::Communicator&)>& body) {
    comm::ClusterOptions options{.processes = 1 + static_cast<int>(draw(4)), .seed = draw(1U << 31U)};
    const bool disturbs = stopped_ < kAttempts && (stopped_ == 0 || draw(3) != 0);
    const bool kills = disturbs && draw(2) == 0;
    every_ = disturbs ? static_cast<std::int64_t>(1 + draw(kills ? 5 : 40)) : 0;
    // A stop is a snapshot too. One that never comes disturbs nothing.
    stop_after_ = disturbs && !kills ? every_ : 0;
    if (kills) options.kill_at_step = 1 + draw(options.processes == 1 ? 200 : 4000);
    whole_.reset();
    next_.reset();
    first_tick_ = -1;
    by_changes_.clear();
    by_changes_.resize(static_cast<std::size_t>(options.processes));
    const comm::ClusterRun ran = comm::run_cluster(options, body);
    const bool again = ran.killed >= 0 || (stop_after_ > 0 && whole_.has_value());
    if (!again) return false;
    ++stopped_;
    // Otherwise it begins where this one began.
    if (whole_) {
        from_.reset();
        from_.emplace(std::move(*whole_));
    }
    return true;
}

void Disturbance::load(sim::Subdomain& subdomain, Place& place) const {
    sim::CodeModules none;
    const auto counters = sim::Loader(subdomain, from_->shares).run({}, none);
    if (!counters) throw std::runtime_error(counters.error().message());
    place.burst = from_->place.burst;
    place.patience = from_->place.patience;
    place.changes.go_on(from_->place.changes);
}

void Disturbance::compare_changes(sim::Subdomain& subdomain) {
    if (subdomain.ensemble.is_free()) return;
    std::unique_ptr<ByChanges>& mine = by_changes_[static_cast<std::size_t>(subdomain.comm.process())];
    if (!mine) mine = std::make_unique<ByChanges>(subdomain);
    sim::CodeModules none;
    const sim::Modules no_modules;
    const std::string wrong = mine->shares.take([&](sim::ShareSink& sink, sim::ChangedChunks* changed) {
        // The changes are known until the snapshots are taken.
        if (changed != nullptr && mine->digest.of(subdomain, *changed) != record::state_digest(subdomain))
            throw std::runtime_error("the digest by changed chunks is not that of the state");
        return sim::Saver(subdomain, no_modules, none, changed).run({}, sink);
    });
    if (!wrong.empty()) throw std::runtime_error("a snapshot by changes: " + wrong);
}

bool Disturbance::before_tick(sim::Subdomain& subdomain, const Place& place) {
    if (every_ == 0) return false;
    if (first_tick_ < 0) first_tick_ = subdomain.tick();
    const std::int64_t ticks = subdomain.tick() - first_tick_;
    if (ticks == 0 || ticks % every_ != 0) return false;
    const int processes = subdomain.comm.processes();
    compare_changes(subdomain);
    if (!next_) next_.emplace(Snapshot{.shares = sim::MemoryShares(static_cast<std::size_t>(processes)), .place = place});
    sim::CodeModules none;
    check(sim::Saver(subdomain, {}, none).run({}, next_->shares.of(subdomain.comm.process())));
    if (++next_->by == processes) {
        whole_.reset();
        whole_.emplace(std::move(*next_));
        next_.reset();
    }
    return stop_after_ > 0;
}

}  // namespace meld::reference
