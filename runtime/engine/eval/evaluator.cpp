#include "runtime/engine/eval/evaluator.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <tuple>

#include "runtime/base/assert.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/base/process/liveness.h"
#include "runtime/engine/eval/worker.h"
#include "runtime/engine/tuple/copy_record.h"
#include "runtime/module/kernel/values.h"

namespace meld::eval {

namespace {

// How many groups of the agenda a worker takes at a time: enough to hide the cost of taking, few enough to balance workers.
constexpr std::size_t kMinGroups = 4, kMaxGroups = 16, kSharesOfThread = 4;
// Where few catoms of each group are on the agenda, a worker takes more groups: modules look ahead only within what they get at once.
constexpr std::size_t kMaxCatoms = kMaxGroups * Agenda::kGroup, kMaxSparseGroups = 1024, kLookedAt = 64;

// How many of these groups have that many catoms on the agenda, about: by some of them.
std::size_t groups_with(const Agenda& agenda, std::span<const u32> groups, std::size_t catoms) {
    const std::size_t step = groups.size() / kLookedAt + 1;
    std::size_t looked_at = 0, found = 0;
    for (std::size_t i = 0; i < groups.size(); i += step, ++looked_at) agenda.each_of(groups[i], [&](u32, u64) { ++found; });
    return catoms * looked_at / std::max<std::size_t>(1, found);
}
// Expired tombstones are removed in the same ticks on every process, however many it has: ranks that grow by more than one a tick can make
// one matter again, and then all processes must agree on whether it still exists.
constexpr i64 kSweepTicks = 64;
// Broadcasts are left where one catom in so many lies in a group that is evaluated.
constexpr std::size_t kDense = 8;

// Marks the neighbours of a catom, several at a time.
void mark_around(const Geometry& g, u32 catom, u64 bits, Agenda& agenda) {
    std::array<u32, 16> others;
    std::size_t count = 0;
    each_link(g, catom, [&](i32, u32 other) {
        others[count++] = other;
        if (count < others.size()) return;
        agenda.mark_all(others, bits);
        count = 0;
    });
    agenda.mark_all({others.data(), count}, bits);
}

// What a great tick has taken is given back while ticks are small: memory for so many stays in any case.
constexpr std::size_t kKept = 4096, kMuchMore = 8;

template <class T>
void empty(std::vector<T>& list) {
    if (list.capacity() > kKept && list.size() < list.capacity() / kMuchMore) {
        std::vector<T> less;
        less.reserve(list.capacity() / 4);
        list.swap(less);
    }
    list.clear();
}

template <class Word>
void swap_words(u8* a, u8* b) {
    Word x, y;
    std::memcpy(&x, a, sizeof x);
    std::memcpy(&y, b, sizeof y);
    std::memcpy(a, &y, sizeof y);
    std::memcpy(b, &x, sizeof x);
}
void swap_records(u8* a, u8* b, u32 bytes) {
    u32 at = 0;
    for (; at + sizeof(u64) <= bytes; at += sizeof(u64)) swap_words<u64>(a + at, b + at);
    for (; at + sizeof(u32) <= bytes; at += sizeof(u32)) swap_words<u32>(a + at, b + at);
    for (; at < bytes; ++at) swap_words<u8>(a + at, b + at);
}

}  // namespace

Evaluator::Evaluator(const ModuleInfo& module, tuple::Columns& columns, Workers& workers, Positions positions)
    : module_(module),
      columns_(columns),
      workers_(workers),
      positions_(std::move(positions)),
      requests_(module, columns),
      broadcasts_(module) {
    Thread::connect_memory(host_);
    Thread::connect_writes(host_);
    Thread::connect_messages(host_);
    Thread::connect_requests(host_);
    Thread::connect_undefined(host_);
    for (u32 c = 0; c < module.column_count; ++c) concerns_ = concerns_ || module.columns[c].concerned != nullptr;
    for (u32 p = 0; p < module.predicate_count; ++p)
        if (module.predicates[p].kind == PredicateKind::Linear && module.predicates[p].column != kNone16)
            linear_predicates_.push_back(static_cast<u16>(p));
    for (int i = 0; i < workers.threads(); ++i) {
        threads_.push_back(std::make_unique<Thread>(module));
        Thread& t = *threads_.back();
        t.owner = this;
        outboxes_.push_back(&t.outbox);
        t.number = i;
        t.host = &host_;
        t.new_chunk(kArena);
    }
    if (module.counts) count_evaluations();
}

void Evaluator::count_evaluations() {
    if (counts_) return;
    counts_.emplace(module_, threads_.size());
    counts_->resize(columns_.count());
    for (std::size_t i = 0; i < threads_.size(); ++i) threads_[i]->counters = &counts_->of(i);
}

void Evaluator::tell_firings(std::vector<bool> rules) {
    told_ = std::move(rules);
    for (auto& t : threads_) t->tells_firings = !told_.empty();
}

std::vector<Firing> Evaluator::firings() const {
    std::vector<Firing> all;
    for (const auto& t : threads_) all.insert(all.end(), t->firings.begin(), t->firings.end());
    return all;
}

// Drops undelivered messages and actions. The columns outlive the evaluator.
Evaluator::~Evaluator() {
    for (auto& t : threads_) t->release_owned();
}

void Evaluator::measure(TickLog& log) {
    // A thousand samples in some seconds. Each costs a few microseconds and, where all processors are busy, takes one from a worker.
    constexpr std::chrono::microseconds kBetweenSamples(4000);
    log_ = &log;
    if (!module_.places) return;
    std::vector<const u32*> places;
    for (const auto& t : threads_) places.push_back(&t->place);
    samples_.emplace(module_, std::move(places));
    sampler_.emplace(kBetweenSamples, [this] { samples_->take(); });
}

const CpuSeconds* Evaluator::end_measuring() {
    log_ = nullptr;
    sampler_.reset();
    return samples_ ? &samples_->seconds() : nullptr;
}

Failure Evaluator::evaluate(SubdomainView& subdomain, const OnExport& on_export) {
    take_agenda(subdomain.geometry);
    if (!acts_) threads_[0]->repeated.rest(subdomain.now, taken(), actions_, timers_);
    subdomain.tombstones = !tombstones_.empty() || has_linear();
    subdomain.undefined = !undefined_.empty();
    requests_.begin_evaluation();
    for (auto& t : threads_) {
        t->subdomain = &subdomain;
        t->trap = Trap::None;
        t->failed_column = kNone32;
        t->failure = {};
        t->awake = 0;
        t->derivations = 0;
        t->dropped = 0;
        t->far_facts = t->far_hops = 0;
        t->greatest_rank = 0;
        t->sequence_of = t->nodes_made_of = kNone32;
        t->greatest_new_node = 0;
        t->cut = t->passed_over = false;
        t->release_owned();
        t->values.clear();
        t->outbox.clear();
        empty(t->records);
        empty(t->rows);
        empty(t->row_changes);
        t->firings.clear();
    }
    MELD_EXPECT(subdomain.columns == columns_.pointers() && (groups_.empty() || subdomain.geometry.catom_state != nullptr),
                "the arrays of the subdomain are not up to date");
    MELD_ASSERT(std::is_sorted(groups_.begin(), groups_.end()), "the agenda is not in the order of memory");
    // An agenda with few groups is that of a wave, whose few rows are not worth looking for at all catoms.
    const bool dense = groups_.size() * Agenda::kGroup * kDense >= columns_.count();
    broadcasts_.begin(subdomain, leave_broadcasts_ && dense, columns_.count());
    if (counts_) counts_->room_for_ports(std::max<std::size_t>(kMaxPorts, subdomain.geometry.most_ports));
    columns_.changes().begin_evaluation();
    const std::size_t share = groups_.size() / (threads_.size() * kSharesOfThread);
    const std::size_t most = std::clamp(groups_with(taken(), groups_, kMaxCatoms), kMaxGroups, kMaxSparseGroups);
    const std::size_t at_once = threads_.size() == 1 ? most : std::clamp(share, kMinGroups, most);
    workers_.run((groups_.size() + at_once - 1) / at_once, [&](int worker, std::size_t block) {
        Thread& t = *threads_[static_cast<std::size_t>(worker)];
        // The user has waited long enough for the end of this tick.
        t.cut = t.cut || interrupt::overdue();
        const std::size_t from = block * at_once, to = std::min(groups_.size(), from + at_once);
        if (!t.cut) evaluate_groups(subdomain, t, worker, std::span(groups_).subspan(from, to - from));
    });
    broadcasts_.end(agenda());
    columns_.changes().end_evaluation(!acts_ ? acts_ : [&](u32 catom) { return waits(subdomain.geometry, catom); });
    enter(log_, TickLog::Stage::Commit);
    if (before_commit_) before_commit_();
    workers_.run(threads_.size(), [&](int, std::size_t i) { commit(subdomain, static_cast<int>(i), on_export); });
    if (concerns_ && !apart_) workers_.run(threads_.size(), [&](int, std::size_t i) { mark_concerned(subdomain.geometry, *threads_[i]); });
    gather(subdomain);
    Failure first;
    for (const auto& t : threads_)
        if (t->failure.trap != Trap::None && (first.trap == Trap::None || t->failure.catom < first.catom)) first = t->failure;
    return first;
}

// Whether what was noted of a catom, or what has arrived in a mailbox, has not been read in this tick. Of ghosts nothing waits.
bool Evaluator::waits(const Geometry& geometry, u32 catom) const {
    const u8 state = geometry.catom_state[catom];
    if (state == kCatomMailbox) return reader_ && !acts_(reader_(catom));
    return state == kCatomOwned && !acts_(catom);
}

void Evaluator::evaluate_groups(const SubdomainView& subdomain, Thread& t, int worker, std::span<const u32> groups) {
    std::array<u32, kMaxCatoms> catoms;
    std::array<u64, kMaxCatoms> dirty;
    std::size_t count = 0;
    for (std::size_t i = 0; i < groups.size(); ++i) {
        taken().each_of(groups[i], [&](u32 catom, u64 bits) {
            // Nothing is evaluated of catoms that live elsewhere, or no longer. No other thread reads the group.
            if (subdomain.geometry.catom_state[catom] != kCatomOwned) return taken().forget(catom);
            catoms[count] = catom;
            dirty[count++] = bits;
        });
        const bool full = count + Agenda::kGroup > kMaxCatoms || i + 1 == groups.size();
        if (!full || count == 0) continue;
        evaluate_block(t, worker, {catoms.data(), count}, {dirty.data(), count});
        count = 0;
        // More of them than expected may lie in these groups.
        if (i + 1 == groups.size()) return;
        liveness::beat();
        t.cut = t.cut || interrupt::overdue();
        if (t.cut) return;
    }
}

void Evaluator::evaluate_block(Thread& t, int worker, std::span<const u32> catoms, std::span<const u64> dirty) {
    t.awake += catoms.size();
    t.trim_chunks();
    const double begin = log_ != nullptr ? seconds_now() : 0;
    if (samples_) samples_->note_worker(worker);
    if (counts_) counts_->begin_block(static_cast<std::size_t>(worker), catoms.size());
    if (still_activated_ && t.still.size() < catoms.size()) t.still.resize(catoms.size());
    t.still_activated = t.still.data();
    t.still_count = 0;
    module_.evaluate(&t, catoms.data(), dirty.data(), static_cast<u32>(catoms.size()));
    t.reserved.clear();
    if (t.still_count > 0) still_activated_(worker, {t.still_activated, t.still_count});
    if (counts_) counts_->end_block(static_cast<std::size_t>(worker), catoms);
    if (samples_) note_place(t, kPlaceNone);
    if (log_ != nullptr) log_->add_busy(worker, seconds_now() - begin);
    if (t.trap == Trap::None) return;
    // Of several failures the one with the least id is reported, whichever thread met it.
    const Failure failure = t.failure_here();
    if (t.failure.trap == Trap::None || failure.catom < t.failure.catom) t.failure = failure;
    t.trap = Trap::None;
    t.failed_column = kNone32;
}

// Makes exported changes visible and wakes their readers. Each catom was evaluated by one thread, so writes never conflict; marks may, but
// they are commutative.
void Evaluator::commit(SubdomainView& subdomain, int thread, const OnExport& on_export) {
    Thread& t = *threads_[static_cast<std::size_t>(thread)];
    const Geometry& g = subdomain.geometry;
    const bool shared = threads_.size() > 1;
    Agenda& next = agenda();
    const auto changed = [&](u32 catom, u16 column) {
        MELD_ASSERT(module_.columns[column].exported && g.catom_state[catom] == kCatomOwned, "catom {}, column {}", catom, column);
        const u64 bits = module_.columns[column].reader_dirty;
        if (!apart_ && shared)
            each_link(g, catom, [&](i32, u32 other) { next.mark_shared(other, bits); });
        else if (!apart_)
            mark_around(g, catom, bits, next);
        if (on_export) on_export(thread, catom, column);
    };
    using Lists = tuple::Columns::Lists;
    t.dropped_of = kNone32;
    constexpr std::size_t kAhead = 8;
    for (std::size_t i = 0; i < t.records.size(); ++i) {
        const PendingRecord& r = t.records[i];
        const ColumnInfo& column = module_.columns[r.column];
        if (i + kAhead < t.records.size()) __builtin_prefetch(columns_.entry(t.records[i + kAhead].column, t.records[i + kAhead].catom), 1);
        if (asks_concerned(r.column)) {
            // What the record was is kept in its place until mark_concerned().
            swap_records(columns_.entry(r.column, r.catom), r.record, column.stride);
            if (on_export) on_export(thread, r.catom, r.column);
            continue;
        }
        if (column.list_count == 0)
            tuple::copy_record(columns_.entry(r.column, r.catom), r.record, column.stride);
        else
            columns_.set_record(r.column, r.catom, r.record, thread, Lists::HandOver);
        changed(r.catom, r.column);
    }
    for (const PendingRows& r : t.rows) {
        columns_.set_rows(r.column, r.catom, r.rows, r.count, thread, Lists::HandOver);
        changed(r.catom, r.column);
    }
    for (const PendingChanges& r : t.row_changes) {
        columns_.change_rows(r.column, r.catom, r.changes, thread);
        changed(r.catom, r.column);
    }
    columns_.release_dropped(thread);
}

void Evaluator::gather(const SubdomainView& subdomain) {
    statistics_ = {};
    passed_over_ = false;
    unsorted_ = requests_.messages();
    actions_ = requests_.actions();
    far_messages_.clear(), births_.clear();
    greatest_new_node_ = 0;
    statistics_.messages = unsorted_.size();
    for (auto& t : threads_) {
        statistics_.awake += t->awake;
        statistics_.derivations += t->derivations;
        statistics_.dropped += t->dropped;
        statistics_.far_facts += t->far_facts;
        statistics_.far_hops += t->far_hops;
        statistics_.cut = statistics_.cut || t->cut;
        passed_over_ = passed_over_ || t->passed_over;
        statistics_.changes += t->records.size() + t->rows.size() + t->row_changes.size();
        statistics_.messages += t->messages.size() + t->outbox.count() + t->outbox.said() + t->far_messages.size();
        far_messages_.insert(far_messages_.end(), t->far_messages.begin(), t->far_messages.end());
        t->far_messages.clear();
        births_.insert(births_.end(), t->births.begin(), t->births.end());
        t->births.clear();
        greatest_new_node_ = std::max(greatest_new_node_, t->greatest_new_node);
        greatest_rank_ = std::max(greatest_rank_, t->greatest_rank);
        if (unsorted_.empty())
            unsorted_.swap(t->messages);
        else
            unsorted_.insert(unsorted_.end(), t->messages.begin(), t->messages.end());
        actions_.insert(actions_.end(), t->actions.begin(), t->actions.end());
        for (const Action& a : t->actions) threads_[0]->repeated.note(a);
        for (const Loss& l : t->losses)
            tombstones_.lose(l.catom, l.predicate, l.key, l.rank, subdomain.now, subdomain.greatest_rank, subdomain.latency);
        for (const Wake& w : t->wakes) timers_.add(subdomain.now, w.tick, w.catom, w.dirty);
        for (const GroupWake& w : t->group_wakes)
            timers_.add_group(subdomain.now, w.tick, w.catom, w.column, w.row, module_.columns[w.column].row_bytes);
        t->put_undefined_aside();
        for (auto& [catom, entries] : t->undefined_left) undefined_.replace(catom, std::move(entries));
        t->undefined_left.clear();
        t->messages.clear();
        t->actions.clear();
        t->losses.clear();
        t->wakes.clear();
        t->group_wakes.clear();
        t->bytes.clear();
    }
    order_messages();
    for (std::vector<FarMessage>* all : {&far_messages_, &births_})
        std::ranges::sort(*all, {}, [](const FarMessage& m) { return std::tuple(m.to, m.from, m.sequence); });
    // What code outside the program asks for is not repeated: the next evaluation finds out what the rules ask for.
    for (const Action& a : requests_.actions())
        if (threads_[0]->repeated.asked(a.catom)) agenda().mark(a.catom, kDirtyWake);
    order_actions(subdomain.geometry);
    threads_[0]->repeated.add_to(actions_, subdomain.geometry);
    if (subdomain.now % kSweepTicks == 0) tombstones_.sweep(subdomain.now, subdomain.greatest_rank, subdomain.latency);
}

void Evaluator::add_changed(const std::vector<bool>& columns, std::vector<u32>& catoms) const {
    const auto add = [&](const auto& changes) {
        for (const auto& change : changes)
            if (columns[change.column]) catoms.push_back(change.catom);
    };
    for (const auto& t : threads_) {
        add(t->records);
        add(t->rows);
        add(t->row_changes);
    }
}

void Evaluator::add_changes(std::vector<Change>& changes) const {
    const auto add = [&](const auto& pending) {
        for (const auto& change : pending) changes.push_back({change.catom, change.column});
    };
    for (const auto& t : threads_) {
        add(t->records);
        add(t->rows);
        add(t->row_changes);
    }
}

void Evaluator::restore_action(u32 catom, u16 predicate, const Value* arguments) {
    MELD_EXPECT(module_.predicates[predicate].kind == PredicateKind::Action, "predicate {}", predicate);
    actions_.push_back({catom, predicate, threads_[0]->keep_values(arguments, module_.predicates[predicate])});
    threads_[0]->repeated.note(actions_.back());
}

}  // namespace meld::eval
