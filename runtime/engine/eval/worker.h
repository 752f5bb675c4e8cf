// A worker of the evaluator. Private to runtime/engine/eval.
#pragma once

#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "runtime/engine/eval/evaluator.h"
#include "runtime/engine/eval/pending.h"
#include "runtime/engine/eval/repeated.h"
#include "runtime/engine/eval/reserved.h"
#include "runtime/engine/eval/tick_arena.h"
#include "runtime/engine/tuple/field.h"
#include "runtime/module/kernel/values.h"

namespace meld::eval {

inline constexpr std::size_t kArena = 1 << 16;
// Requests of so many bytes get reserved memory in any case, others if so much of the last chunk of scratch memory is used.
inline constexpr u64 kAlwaysReserved = 1 << 20;
inline constexpr std::ptrdiff_t kMuchScratch = 64 << 20;

// A worker's Eval and the data it has set aside for the end of the tick. The module sees only the Eval.
struct Evaluator::Thread : Eval {
    explicit Thread(const ModuleInfo& module) : outbox(module), repeated(module) { outgoing = outbox.places(); }

    // Set what a module may ask for while it evaluates a catom (host.cpp).
    static void connect_memory(Host& host);
    static void connect_writes(Host& host);
    static void connect_messages(Host& host);
    static void connect_requests(Host& host);
    static void connect_undefined(Host& host);
    Evaluator* owner = nullptr;
    int number = 0;
    std::vector<std::unique_ptr<u8[]>> chunks;
    Reserved reserved;
    // Until the next evaluation, but their bytes are used up before.
    std::vector<PendingRecord> records;
    std::vector<PendingRows> rows;
    std::vector<PendingChanges> row_changes;
    // Records and rows of this tick; the arguments of messages and actions stay until the next evaluation.
    Kept<u8> bytes;
    std::vector<Message> messages;
    Outbox outbox;  // Until the next evaluation.
    std::vector<FarMessage> far_messages, births;
    // Of the catom that last made one, and of all.
    u32 nodes_made = 0, nodes_made_of = kNone32;
    u64 greatest_new_node = 0;
    std::vector<Action> actions;
    Repeated repeated;  // Of the first worker only: one thread puts them together.
    Kept<Value> values;
    std::vector<Value> arguments;  // Of a row, on its way to a network.
    // The lists among them and the stored ones in rows that were sent, which messages, actions and rows own until the next evaluation.
    std::vector<const List*> owned;
    u32 dropped_of = kNone32;
    std::vector<Loss> losses;
    std::vector<Wake> wakes;
    std::vector<GroupWake> group_wakes;
    std::vector<Firing> firings;  // Until the next evaluation.
    std::size_t awake = 0;        // Catoms that it has evaluated.
    u32 sequence = 0;
    u32 sequence_of = kNone32;
    u32 failed_column = kNone32;  // Of a trap at the end of an evaluation.
    bool cut = false;             // It has skipped catoms.
    Failure failure;
    // Undefined derivations of the catom that last asked for them or noted one, and those that earlier catoms have left.
    u32 undefined_of = kNone32;
    Undefined::Entries undefined_here;
    std::vector<std::pair<u32, Undefined::Entries>> undefined_left;
    std::vector<u32> concerned;  // Of one record; used again and again.
    std::vector<u32> still;      // Room for Eval::still_activated.
    bool passed_over = false;

    // Whether the catom under evaluation has made this node in this tick, and given it a fact.
    bool bears(u64 node) const {
        if (nodes_made_of != catom) return false;
        const u64 maker = id_of(subdomain->geometry, catom);
        for (auto birth = births.rbegin(); birth != births.rend() && birth->from == maker; ++birth)
            if (birth->to == node) return true;
        return false;
    }
    // The failure that Eval::trap describes, with its catom.
    Failure failure_here() const {
        Failure f{trap, trap_rule, failed_column, id_of(subdomain->geometry, catom), subdomain->now, trap_left, trap_right, trap_real, {}};
        if (trap == Trap::NotAnInt || trap == Trap::NotAFloat) std::copy(std::begin(trap_text), std::end(trap_text), f.text);
        return f;
    }
    Undefined::Entries& undefined_entries() {
        if (undefined_of != catom) {
            put_undefined_aside();
            undefined_of = catom;
            if (const Undefined::Entries* before = owner->undefined_.of(catom)) undefined_here = *before;
        }
        return undefined_here;
    }
    void put_undefined_aside() {
        if (undefined_of != kNone32) undefined_left.emplace_back(undefined_of, std::move(undefined_here));
        undefined_here.clear();
        undefined_of = kNone32;
    }
    u32 next_sequence() {
        if (sequence_of != catom) sequence = 0;
        sequence_of = catom;
        return sequence++;
    }
    u8* keep(const void* from, std::size_t size) { return bytes.copy(static_cast<const u8*>(from), size); }
    // Adds what the group has lost earlier in this evaluation of the catom; linear rules bring views to their fixpoint several times.
    bool lost_now(u16 predicate, u64 key, bool remembered, Tombstone& memory) const {
        bool any = false;
        for (std::size_t i = losses.size(); i-- > 0 && losses[i].catom == catom;) {
            if (losses[i].predicate != predicate || losses[i].key != key) continue;
            memory = {remembered || any ? std::min(memory.least_rank, losses[i].rank) : losses[i].rank, subdomain->now};
            any = true;
        }
        return any;
    }
    const Value* keep_values(const Value* from, const PredicateInfo& predicate) {
        Value* const copy = values.copy(from, predicate.arity);
        for (u32 i = 0; i < predicate.arity; ++i) {
            if (predicate.fields[i].type < ValueType::String) continue;
            const List* kept = owner->columns_.lists().keep(tuple::type_of(owner->module_, predicate.fields[i]), from[i].list, number);
            copy[i].list = kept;
            if (kept != nullptr) owned.push_back(kept);
            check_length(predicate.column);
        }
        return copy;
    }
    // Copies a list of a row that is sent; one that is stored is shared.
    void send_list(tuple::Type type, u16 column, u8* field) {
        const List* list = nullptr;
        std::memcpy(&list, field, sizeof list);
        tuple::ListStore& lists = owner->columns_.lists();
        if (list != nullptr && list->stored != 0) {
            lists.share(list);
            owned.push_back(list);
            outbox.share(column);
        } else {
            list = lists.copy(type, list, outbox.lists(column), number);
            std::memcpy(field, &list, sizeof list);
        }
    }
    void release_owned() {
        for (const List* list : owned) owner->columns_.lists().release(list, number);
        owned.clear();
    }
    // Called after lists were kept for facts of this column.
    void check_length(u16 column) {
        const auto [items, text] = owner->columns_.lists().too_long(number);
        if (items == 0) return;
        if (trap == Trap::None) failed_column = column;
        meld::trap(*this, text ? Trap::TextTooLong : Trap::TooLong, rule, static_cast<i64>(items), static_cast<i64>(subdomain->max_list));
    }
    // Called before a private column is written: lists that rows of the catom have lost stay alive until all its columns are written,
    // because it may move them from one column to the next.
    void begin_write(const ColumnInfo& column) {
        if (column.list_count == 0 || dropped_of == catom) return;
        owner->columns_.release_dropped(number);
        dropped_of = catom;
    }
    void new_chunk(std::size_t size) {
        chunks.push_back(std::make_unique_for_overwrite<u8[]>(size));
        arena = arena_start = chunks.back().get();
        arena_end = arena + size;
    }
    // Only the last, largest chunk outlives a block.
    void trim_chunks() {
        if (chunks.size() > 1) chunks.erase(chunks.begin(), chunks.end() - 1);
    }
};

inline Evaluator::Thread& Evaluator::of(Eval* e) { return *static_cast<Thread*>(e); }

}  // namespace meld::eval
