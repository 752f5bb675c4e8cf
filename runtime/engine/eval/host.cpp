// What a module may ask of the evaluator while it evaluates a catom: the functions of Host (runtime/module/abi/module_abi.h).
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "runtime/base/assert.h"
#include "runtime/base/random.h"
#include "runtime/engine/eval/evaluator.h"
#include "runtime/engine/eval/nearest_rotation.h"
#include "runtime/engine/eval/worker.h"
#include "runtime/engine/tuple/copy_record.h"
#include "runtime/module/kernel/values.h"

namespace meld::eval {

void Evaluator::Thread::connect_memory(Host& host) {
    host.more_arena = [](Eval* e, u64 bytes) {
        Thread& t = of(e);
        const std::size_t before = static_cast<std::size_t>(t.arena_end - t.arena_start);
        const std::size_t size = std::max<std::size_t>(before * 2, bytes * 2);
        if (size > kMaxChunk) meld::trap(*e, Trap::TooMuchMemory, e->rule, static_cast<i64>(size));
        // The evaluation then ends at its next check; until then it gets what it asks for.
        t.new_chunk(size > kMaxChunk ? std::max<std::size_t>(kArena, bytes) : size);
    };
    host.reserve = [](Eval* e, u64 bytes, u64 needed) -> void* {
        Thread& t = of(e);
        // Scratch memory is warm, and costs less while there is not much of it.
        if (needed < kAlwaysReserved && t.arena - t.arena_start < kMuchScratch) return nullptr;
        return t.reserved.take(e->catom, bytes);
    };
    host.give_back = [](Eval* e, void* memory) { of(e).reserved.give_back(memory); };
    host.empty = [](Eval* e, void* memory) { of(e).reserved.empty(memory); };
}

// What an evaluation writes of its catom: records, rows, and the values that groups have lost.
void Evaluator::Thread::connect_writes(Host& host) {
    host.export_record = [](Eval* e, u16 column, const void* record) {
        Thread& t = of(e);
        tuple::Columns& all = t.owner->columns_;
        const ColumnInfo& c = t.owner->module_.columns[column];
        if (c.exported) {
            u8* const kept = t.bytes.take(c.stride);
            tuple::copy_record(kept, static_cast<const u8*>(record), c.stride);
            t.records.push_back({e->catom, column, kept});
            if (c.list_count == 0) return;
            all.keep_lists(column, kept, 1, t.number);
        } else {
            t.begin_write(c);
            all.set_record(column, e->catom, record, t.number);
        }
        if (c.list_count > 0) t.check_length(column);
    };
    host.assign_rows = [](Eval* e, u16 column, const void* rows, u32 count) {
        Thread& t = of(e);
        tuple::Columns& all = t.owner->columns_;
        const ColumnInfo& c = t.owner->module_.columns[column];
        if (c.exported) {
            t.rows.push_back({e->catom, column, count, t.keep(rows, std::size_t{count} * c.row_bytes)});
            all.keep_lists(column, t.rows.back().rows, count, t.number);
        } else {
            t.begin_write(c);
            all.set_rows(column, e->catom, rows, count, t.number);
        }
        if (c.list_count > 0) t.check_length(column);
    };
    host.change_rows = [](Eval* e, u16 column, const RowChanges* changes) {
        Thread& t = of(e);
        const std::size_t row_bytes = t.owner->module_.columns[column].row_bytes;
        const auto* const from = reinterpret_cast<const u8*>(changes + 1);
        std::size_t bytes = row_bytes * (std::size_t{changes->removed} + changes->added);
        if (changes->placed != 0)
            bytes = static_cast<std::size_t>(reinterpret_cast<const u8*>(places_of(*changes, row_bytes) + changes->added) - from);
        RowChanges* kept = t.owner->columns_.changes().make(column, 0, static_cast<u32>((bytes + row_bytes - 1) / row_bytes), t.number);
        *kept = *changes;
        if (bytes > 0) std::memcpy(kept + 1, from, bytes);
        t.row_changes.push_back({e->catom, column, kept});
    };
    host.tombstone = [](Eval* e, u16 predicate, u64 key, Tombstone* out) {
        const Thread& t = of(e);
        if (predicate == kNone16) return t.owner->tombstones_.has(e->catom) || (!t.losses.empty() && t.losses.back().catom == e->catom);
        const Tombstones::Entry* found = t.owner->tombstones_.find(e->catom, predicate, key);
        const bool before =
            found != nullptr && !Tombstones::expired(*found, e->subdomain->now, e->subdomain->greatest_rank, e->subdomain->latency);
        if (before) *out = {found->least_rank, found->time};
        return (t.owner->has_linear() && t.lost_now(predicate, key, before, *out)) || before;
    };
    host.lose = [](Eval* e, u16 predicate, u64 key, u32 rank) { of(e).losses.push_back({e->catom, predicate, key, rank}); };
}

// Linear facts for other catoms, near and far, and nodes that a catom makes.
void Evaluator::Thread::connect_messages(Host& host) {
    host.send = [](Eval* e, u32 to, u16 predicate, const Value* arguments) {
        Thread& t = of(e);
        MELD_EXPECT(predicate < t.owner->module_.predicate_count, "predicate {}", predicate);
        const Geometry& g = e->subdomain->geometry;
        if (g.catom_state[to] == kCatomMailbox) to = g.catom_site[to];
        t.messages.push_back({to, predicate, id_of(e->subdomain->geometry, e->catom), t.next_sequence(),
                              t.keep_values(arguments, t.owner->module_.predicates[predicate])});
    };
    host.send_row = [](Eval* e, u32 to, u16 predicate, const void* row) {
        Thread& t = of(e);
        const ModuleInfo& all = t.owner->module_;
        const PredicateInfo& p = all.predicates[predicate];
        if (t.owner->apart_) {
            // A network gives each message its number.
            tuple::read_row(p, static_cast<const u8*>(row), t.arguments);
            return e->host->send(e, to, predicate, t.arguments.data());
        }
        const ColumnInfo& column = all.columns[p.column];
        u8* const kept = t.outbox.add(p.column, to, e->catom);
        std::memcpy(kept, row, column.row_bytes);
        for (u32 i = 0; i < column.list_count; ++i) t.send_list({all.types, column.list_types[i]}, p.column, kept + column.list_offsets[i]);
        if (column.list_count > 0) t.check_length(p.column);
    };
    host.send_far = [](Eval* e, u64 to, u16 predicate, const Value* arguments) {
        Thread& t = of(e);
        const u64 from = id_of(e->subdomain->geometry, e->catom);
        if (!t.owner->anywhere_ || to == from) {
            ++e->dropped;
            return false;
        }
        ++e->far_hops;
        (t.bears(to) ? t.births : t.far_messages)
            .push_back({to, predicate, from, t.next_sequence(), t.keep_values(arguments, t.owner->module_.predicates[predicate])});
        return true;
    };
    // A node that this catom has made in this tick is no node yet: what it sends there comes with what the node begins with.
    host.next_hop = [](Eval* e, u64 target) {
        const Thread& t = of(e);
        return t.owner->anywhere_ && t.bears(target) ? target : t.owner->next_hop_(e->catom, target);
    };
    host.new_node = [](Eval* e) {
        Thread& t = of(e);
        if (t.nodes_made_of != e->catom) t.nodes_made = 0;
        t.nodes_made_of = e->catom;
        const u64 id = t.owner->new_node_(e->catom, t.nodes_made++);
        t.greatest_new_node = std::max(t.greatest_new_node, id);
        return id;
    };
    host.bear = [](Eval* e, u64 node, u16 predicate, const Value* arguments) {
        Thread& t = of(e);
        t.births.push_back({node, predicate, id_of(e->subdomain->geometry, e->catom), t.next_sequence(),
                            t.keep_values(arguments, t.owner->module_.predicates[predicate])});
    };
}

// Actions, wakes, and questions that the run answers.
void Evaluator::Thread::connect_requests(Host& host) {
    host.act = [](Eval* e, u16 predicate, const Value* arguments) {
        Thread& t = of(e);
        MELD_EXPECT(t.owner->module_.predicates[predicate].kind == PredicateKind::Action, "predicate {}", predicate);
        t.actions.push_back({e->catom, predicate, t.keep_values(arguments, t.owner->module_.predicates[predicate])});
    };
    host.wake = [](Eval* e, i64 tick, u64 dirty) {
        MELD_EXPECT(tick > e->subdomain->now, "catom {} in tick {}", e->catom, tick);
        of(e).wakes.push_back({tick, e->catom, dirty});
    };
    host.wake_group = [](Eval* e, i64 tick, u16 predicate, const void* row) {
        Thread& t = of(e);
        const u16 column = t.owner->module_.predicates[predicate].column;
        if (tick != 0) t.group_wakes.push_back({tick, e->catom, column, t.keep(row, t.owner->module_.columns[column].row_bytes)});
    };
    host.fired = [](Eval* e, u32 rule, u32 count, const BoundVariable* variables, const Value* values) {
        Thread& t = of(e);
        if (!t.owner->told_[rule]) return;
        t.firings.push_back(
            {rule, id_of(e->subdomain->geometry, e->catom), pack_bound(t.owner->module_.types, {variables, count}, values)});
    };
    host.random = [](Eval* e) {
        return random_bits(e->subdomain->seed, id_of(e->subdomain->geometry, e->catom), static_cast<u64>(e->subdomain->now), e->draws++);
    };
    host.nearest_rotation = nearest_rotation;
    host.position = [](Eval* e, double out[3]) { of(e).owner->positions_(e->catom, out); };
    host.broken = [](Eval* e, const char* condition, const char* file, i32 line) {
        assertion_failed("kernel check", condition, file, line,
                         fmt::format("catom @{}, tick {}, rule {}, stratum {}", id_of(e->subdomain->geometry, e->catom), e->subdomain->now,
                                     e->rule, e->stratum));
    };
}

// Derivations without a value (docs/design.md, "Undefined derivations").
void Evaluator::Thread::connect_undefined(Host& host) {
    host.undefined = [](Eval* e) {
        e->undefined = 0;
        for (const Undefined::Entry& entry : of(e).undefined_entries()) e->undefined |= undefined_bit(entry.stratum);
    };
    host.note_undefined = [](Eval* e) {
        Thread& t = of(e);
        Undefined::Entries& all = t.undefined_entries();
        const Undefined::Entry entry{e->stratum, t.failure_here()};
        const auto at = std::lower_bound(all.begin(), all.end(), entry, Undefined::by_rule);
        // The first of each rule stays.
        if (at == all.end() || at->failure.rule != entry.failure.rule) all.insert(at, entry);
        e->undefined |= undefined_bit(e->stratum);
        e->trap = Trap::None;
    };
    host.forget_undefined = [](Eval* e) {
        std::erase_if(of(e).undefined_entries(), [&](const Undefined::Entry& entry) { return entry.stratum == e->stratum; });
        e->host->undefined(e);
    };
    host.undefined_rule = [](Eval* e, u32 number) {
        const Undefined::Entries& all = of(e).undefined_entries();
        return number < all.size() ? all[number].failure.rule : kNone32;
    };
    host.stop_undefined = [](Eval* e, u32 number) {
        const Failure& f = of(e).undefined_entries().at(number).failure;
        e->trap = f.trap;
        e->trap_rule = f.rule;
        e->trap_left = f.left;
        e->trap_right = f.right;
        e->trap_real = f.real;
        std::copy(std::begin(f.text), std::end(f.text), e->trap_text);
    };
}

}  // namespace meld::eval
