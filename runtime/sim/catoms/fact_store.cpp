#include "runtime/sim/catoms/fact_store.h"

#include <type_traits>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/engine/tuple/arrived_rows.h"

namespace meld::sim {

FactStore::FactStore(const ModuleInfo& module, Workers& workers, eval::Positions positions)
    : columns(module, workers.threads()), evaluator(module, columns, workers, std::move(positions)), module_(module), workers_(workers) {}

FactStore::~FactStore() {
    for (u32 i = 0; i < parameters_.size(); ++i) columns.lists().release({module_.types, module_.parameters[i].deep}, parameters_[i], 0);
}

void FactStore::resize(std::size_t catoms) {
    columns.resize(catoms, &workers_);
    // Room that was made ahead, as for mailboxes, stays.
    evaluator.resize(columns.count());
    for (const auto& follower : followers_) follower->resize(columns.count());
    if (eval::Counts* counts = evaluator.counts()) counts->resize(columns.count());
}

void FactStore::forget(u32 catom, u64 id) {
    MELD_EXPECT(catom < columns.count(), "catom {} of {}", catom, columns.count());
    columns.clear(catom, 0);
    touch(catom);
    evaluator.agenda().forget(catom);
    evaluator.tombstones().forget(catom);
    evaluator.undefined().forget(catom);
    evaluator.timers().forget(catom);
    if (eval::Counts* counts = evaluator.counts()) counts->forget(catom, id);
}

void FactStore::wake_moved(u32 catom) {
    evaluator.timers().forget(catom);
    mark(catom, kDirtyWake | kDirtyLinks | kDirtyPlace);
}

void FactStore::check_given(u32 predicate) const {
    MELD_EXPECT(predicate < module_.predicate_count, "predicate {}", predicate);
    const u16 column = module_.predicates[predicate].column;
    MELD_CHECK(column != kNone16 && !module_.columns[column].exported, "{} is no given predicate", module_.predicates[predicate].name);
}

bool FactStore::give(u32 predicate, u32 catom, const Value* arguments, int worker) {
    check_given(predicate);
    if (!tuple::give_fact(module_, columns, predicate, catom, arguments, worker)) return false;
    mark(catom, own_dirty(predicate));
    return true;
}

void FactStore::give_all(u32 predicate, u32 catom, std::vector<const Value*>& facts) {
    check_given(predicate);
    if (module_.predicates[predicate].storage != Storage::Rows) {
        for (const Value* arguments : facts) give(predicate, catom, arguments);
    } else if (tuple::give_facts(module_, columns, predicate, catom, facts, rows_, 0)) {
        mark(catom, own_dirty(predicate));
    }
}

void FactStore::deliver_sent(const Geometry& geometry, bool everyone) {
    bool any = false;
    for (const u16 predicate : evaluator.linear_predicates()) {
        const u16 column = module_.predicates[predicate].column;
        if (!evaluator.sent_rows(column)) continue;
        if (everyone)
            deliver_rows(column, [](u32) { return true; });
        else
            deliver_rows(column, [state = geometry.catom_state](u32 to) { return state[to] == kCatomOwned; });
        any = true;
    }
    if (!any) columns.arrived().rest();
}

template <class Here>
void FactStore::deliver_rows(u16 column, Here here) {
    tuple::ArrivedRows& arrived = columns.arrived();
    const ColumnInfo& info = module_.columns[column];
    const bool shares = info.list_count > 0 && evaluator.shares_lists(column);
    arrived.open(column, shares);
    evaluator.each_sent_entry(column,
                              [count = arrived.counter(here)](const u32* to, u32 receivers, u32, const u8*) { count(to, receivers); });
    arrived.make_room();
    const auto place = [&](auto bytes) {
        evaluator.each_sent_entry(
            column, [place = arrived.placer<bytes>(here)](const u32* to, u32 receivers, u32, const u8* row) { place(to, receivers, row); });
    };
    if (shares) {
        const auto place_one = arrived.placer<0>(here);
        evaluator.each_sent(column, [&](u32 to, u32, const u8* row) {
            if (u8* const placed = place_one(&to, 1, row)) columns.share_lists(column, placed, 1);
        });
    } else {
        // A copy of a length known at compile time is a few instructions.
        switch (info.row_bytes) {
            case 8:
                place(std::integral_constant<u32, 8>{});
                break;
            case 16:
                place(std::integral_constant<u32, 16>{});
                break;
            case 24:
                place(std::integral_constant<u32, 24>{});
                break;
            default:
                place(std::integral_constant<u32, 0>{});
        }
    }
    if (info.list_count > 0) evaluator.hand_over_lists(column, arrived.lists());
    arrived.end(workers_);
    mark_arrived(column);
}

void FactStore::mark_arrived(u16 column) {
    const tuple::ArrivedRows& arrived = columns.arrived();
    evaluator.agenda().mark_all(arrived.receivers(), module_.columns[column].own_dirty);
    if (followers_.empty()) return;
    for (const u32 catom : arrived.receivers()) touch(catom);
}

void FactStore::deliver_broadcasts(const Geometry& geometry) {
    eval::Broadcasts& left = evaluator.broadcasts();
    if (!left.waiting()) return;
    tuple::ArrivedRows& arrived = columns.arrived();
    const auto everyone = [](u32) { return true; };
    for (u32 i = 0; i < module_.broadcast_count; ++i) {
        const u16 column = module_.broadcasts[i];
        const auto each_copy = [&](const auto& visit) {
            left.each(column, [&](u32 from, const u8* row) { each_link(geometry, from, [&](i32, u32 to) { visit(to, row); }); });
        };
        arrived.open(column, false);
        each_copy([count = arrived.counter(everyone)](u32 to, const u8*) { count(&to, 1); });
        arrived.make_room();
        each_copy([place = arrived.placer<0>(everyone)](u32 to, const u8* row) { place(&to, 1, row); });
        arrived.end(workers_);
        mark_arrived(column);
    }
    left.delivered();
}

bool FactStore::take(u32 predicate, u32 catom, const Value* arguments, int worker) {
    check_given(predicate);
    if (!tuple::take_fact(module_, columns, predicate, catom, arguments, worker)) return false;
    mark(catom, own_dirty(predicate));
    return true;
}

bool FactStore::give_shared(u32 predicate, u32 catom, const Value* arguments, int worker) {
    check_given(predicate);
    touch_shared(catom);
    return tuple::give_fact(module_, columns, predicate, catom, arguments, worker);
}

bool FactStore::take_shared(u32 predicate, u32 catom, const Value* arguments, int worker) {
    check_given(predicate);
    touch_shared(catom);
    return tuple::take_fact(module_, columns, predicate, catom, arguments, worker);
}

void FactStore::pack(u32 catom, ByteWriter& out) const {
    columns.pack(catom, tuple::Columns::Which::All, out);
    out.write(evaluator.agenda().dirty(catom));
    const std::vector<eval::Tombstones::Entry> losses = evaluator.tombstones().of(catom);
    out.write_count(losses.size());
    for (const auto& loss : losses) out.write(loss);
    const auto* undefined = evaluator.undefined().of(catom);
    out.write_count(undefined == nullptr ? 0 : undefined->size());
    if (undefined != nullptr)
        for (const auto& entry : *undefined) out.write(entry);
}

void FactStore::unpack(u32 catom, ByteReader& in) {
    columns.unpack(catom, tuple::Columns::Which::All, in, 0);
    mark(catom, in.read<u64>() | kDirtyWake | kDirtyLinks);
    std::vector<eval::Tombstones::Entry> losses(in.read_count(sizeof(eval::Tombstones::Entry)));
    for (auto& loss : losses) loss = in.read<eval::Tombstones::Entry>();
    evaluator.tombstones().restore(catom, losses);
    eval::Undefined::Entries undefined(in.read_count(sizeof(eval::Undefined::Entry)));
    for (auto& entry : undefined) entry = in.read<eval::Undefined::Entry>();
    evaluator.undefined().restore(catom, std::move(undefined));
}

Touched& FactStore::follow(Follows what) {
    if (followers_.empty()) {
        committed_.assign(module_.column_count, false);
        for (u32 i = 0; i < module_.predicate_count; ++i) {
            const PredicateInfo& p = module_.predicates[i];
            if (p.auxiliary || p.column == kNone16 || p.kind == PredicateKind::Action) continue;
            const bool exported = module_.columns[p.column].exported, given = p.kind == PredicateKind::Sensed || p.base == i;
            committed_[p.column] = exported;
            // What is given or sensed no rule derives; but linear facts are consumed.
            writes_private_ = writes_private_ || (!exported && (!given || p.kind == PredicateKind::Linear));
        }
    }
    followers_.push_back(std::make_unique<Touched>(columns.count(), what));
    return *followers_.back();
}

void FactStore::touch_evaluated() {
    if (followers_.empty()) return;
    bool only_held = true;
    for (const auto& follower : followers_) {
        if (follower->follows() == Follows::WhatIsHeld)
            evaluator.each_evaluated([&](u32 catom, u64) { follower->add(catom); });
        else
            only_held = false;
    }
    if (only_held) return;
    if (writes_private_) return evaluator.each_evaluated([&](u32 catom, u64) { touch(catom); });
    changed_.clear();
    evaluator.add_changed(committed_, changed_);
    for (const u32 catom : changed_) touch(catom);
}

std::size_t FactStore::bytes() const {
    std::size_t total = columns.bytes() + evaluator.bytes();
    for (const auto& follower : followers_) total += follower->bytes();
    return total;
}

void FactStore::add_parameter(tuple::Type type, Value value) { parameters_.push_back(columns.lists().keep(type, value, 0)); }

}  // namespace meld::sim
