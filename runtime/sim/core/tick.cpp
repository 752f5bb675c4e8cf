#include "runtime/sim/core/tick.h"

#include <algorithm>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/base/process/liveness.h"
#include "runtime/base/process/stage_clock.h"
#include "runtime/module/abi/actions.h"

namespace meld::sim {

void Tick::begin() {
    Subdomain& s = subdomain_;
    const i64 now = ++s.abi_.now;
    liveness::begin_tick(now);
    if (s.log() != nullptr) s.log()->begin_tick(now);
    const auto here = [&](u32 catom) { return catom < s.ensemble.index_count() && s.owned(catom); };
    const auto wake = [&](u32 catom, u64 bits) {
        if (here(catom)) s.mark(catom, bits);
    };
    const auto wake_group = [&](u32 catom, u16 column, const u8* row) {
        if (!here(catom)) return;
        s.facts_.columns.note_woken(column, catom, row, 0);
        s.mark(catom, kDirtyGroups);
    };
    s.facts_.evaluator.timers().fire(now, wake, wake_group);
    if (s.turns_) s.turns_->take(s.program_actions, s.actions());
    if (s.totals.rested) s.facts_.evaluator.end_quarantines(now + Turns::kUntilRest, wake, wake_group);
    MELD_ENSURE(s.timers().empty() || s.timers().next() > now, "a timer of tick {} is left in tick {}", s.timers().next(), now);
    if (!s.network_) return;
    s.network_->take_down(now, [&](Catom catom) { wake(catom, kDirtyLinks); });
    // Mailboxes are taken away before anything arrives in them.
    s.network_->follow_links(now);
    s.network_->settle(now);
    s.refresh();
    s.network_->arrive(s.tick());
}

const Totals& Tick::end() {
    Subdomain& s = subdomain_;
    if (s.network_) {
        // What a new neighbour tells may be known at once.
        s.network_->follow_links(s.tick());
        s.refresh();
        s.network_->arrive(s.tick());
    }
    s.refresh();
    if (s.turns_) s.turns_->choose(s.tick(), [&](Catom catom) { return s.is_silent(catom); });
    MELD_EXPECT(s.abi_.greatest_rank <= s.totals.greatest_rank, "rank {} was known before {}", s.abi_.greatest_rank,
                s.totals.greatest_rank);
    s.abi_.greatest_rank = s.totals.greatest_rank;
    eval::Failure failure;
    {
        const StageClock clock(evaluation_s_);
        liveness::enter(liveness::Phase::Evaluation);
        enter(s.log(), TickLog::Stage::Evaluation);
        eval::Evaluator::OnExport note;
        if (exchange_.follows_exports()) note = [&](int worker, u32 catom, u16 column) { exchange_.note_export(worker, catom, column); };
        failure = s.facts_.evaluator.evaluate(s.abi_, note);
        s.facts_.touch_evaluated();
    }
    const StageClock clock(exchange_s_);
    liveness::enter(liveness::Phase::Exchange);
    enter(s.log(), TickLog::Stage::Exchange);
    exchange_.run();
    // Links to ghosts that have changed, and linear facts under way, have got mailboxes.
    if (s.network_) s.refresh();
    s.share_routes();
    enter(s.log(), TickLog::Stage::Agreement);
    s.status_.totals = agree(totals_of_this_process(failure));
    liveness::enter(liveness::Phase::Recording);
    enter(s.log(), TickLog::Stage::Recording);
    s.status_.end_tick(s.tick(), s.totals.failure.trap == Trap::None && !s.totals.tick.cut);
    return s.totals;
}

void Tick::end_early() {
    Subdomain& s = subdomain_;
    s.abi_.now = s.status_.last_tick();
    if (s.alone()) return;
    ByteWriter mine;
    mine.write(s.status_.half_way());
    bool anywhere = false;
    for (const std::byte each : s.comm.allgather(mine.view())) anywhere = anywhere || each != std::byte{0};
    s.status_.end_early(anywhere);
}

eval::Failure Tick::first_undefined() const {
    const Subdomain& s = subdomain_;
    ByteWriter mine;
    mine.write(s.facts_.evaluator.undefined().first());
    const std::vector<std::byte> all = s.comm.allgather(mine.view());
    ByteReader in(all, "the first undefined derivations of all processes");
    eval::Failure first;
    for (int rank = 0; rank < s.comm.processes(); ++rank) {
        const auto other = in.read<eval::Failure>();
        if (other.trap != Trap::None && (first.trap == Trap::None || eval::Undefined::earlier(other, first))) first = other;
    }
    return first;
}

Totals Tick::totals_of_this_process(const eval::Failure& failure) {
    Subdomain& s = subdomain_;
    Totals mine;
    mine.tick = s.facts_.evaluator.statistics();
    if (s.network_) mine.tick.dropped += s.network_->take_lost();
    mine.tick.dropped += exchange_.take_lost();
    mine.catoms = s.ensemble.owned_count();
    mine.bytes = s.bytes();
    mine.actions = s.actions().size();
    for (const eval::Action& a : s.actions()) {
        const ActionInfo& action = info(s.kind_of(a));
        mine.creations_requested += action.has(ActionInfo::kCreates);
        mine.teleports += action.has(ActionInfo::kTeleports);
        mine.finished = mine.finished || action.has(ActionInfo::kEndsRun);
    }
    mine.sent_bytes = exchange_.sent_bytes();
    mine.lost = std::exchange(s.status_.lost, 0);
    mine.links_cut = std::exchange(s.status_.links_cut, 0);
    mine.links_made = std::exchange(s.status_.links_made, 0);
    mine.nodes_made = std::exchange(s.status_.nodes_made, 0);
    mine.awake = !s.agenda().empty() || s.facts_.evaluator.passed_over() || mine.actions > 0 || s.status_.moving ||
                 (s.network_ && s.network_->busy());
    mine.timers = !s.timers().empty();
    mine.quarantines = s.turns_ && s.timers().waits_late(s.tick() + Turns::kUntilRest);
    mine.waiting = mine.timers || s.world.expects_after(s.tick()) || !s.status_.dying.empty();
    mine.undefined = !s.facts_.evaluator.undefined().empty();
    mine.stop = s.status_.stop_requested;
    mine.save = s.status_.save_requested;
    mine.greatest_rank = s.facts_.evaluator.greatest_rank();
    mine.failure = failure;
    return mine;
}

Totals Tick::agree(const Totals& mine) {
    Totals sum = mine;
    if (!subdomain_.alone()) {
        ByteWriter bytes;
        bytes.write(mine);
        const std::vector<std::byte> all = subdomain_.comm.allgather(bytes.view());
        ByteReader in(all, "the totals of all processes");
        sum = {};
        for (int rank = 0; rank < subdomain_.comm.processes(); ++rank) sum.add(in.read<Totals>());
        MELD_ENSURE(in.done(), "{} bytes are left", in.left());
    }
    // Nobody has work but those who wait for this.
    sum.rested = sum.quarantines && !sum.awake;
    sum.awake = sum.awake || sum.rested;
    return sum;
}

}  // namespace meld::sim
