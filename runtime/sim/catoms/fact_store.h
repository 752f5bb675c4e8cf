// What a process's catoms hold: facts in columns, the agenda, the tombstones of retraction, and timers.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/base/process/parallel_for.h"
#include "runtime/engine/eval/evaluator.h"
#include "runtime/engine/tuple/columns.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/module/abi/module_abi.h"
#include "runtime/sim/catoms/touched.h"

namespace meld::sim {

class FactStore {
  public:
    FactStore(const ModuleInfo& module, Workers& workers, eval::Positions positions);
    ~FactStore();

    // Makes room for this many catoms; new ones are empty.
    void resize(std::size_t catoms);
    // The catom is removed from this process, with everything stored for it.
    void forget(u32 catom, u64 id);
    // Drops the catom's timers, which it sets again, as when it migrates: how often it is evaluated must not depend on where it came from.
    void wake_moved(u32 catom);

    // Facts given from outside: returns whether they change anything; if so, the catom is marked. Several workers may do so at once, for
    // catoms of different blocks of the agenda.
    bool give(u32 predicate, u32 catom, const Value* arguments, int worker = 0);
    void give_all(u32 predicate, u32 catom, std::vector<const Value*>& facts);
    // Gives the rows that catoms of this process have sent in the last evaluation to their receivers here, which are marked. everyone: all
    // catoms are here.
    void deliver_sent(const Geometry& geometry, bool everyone);
    // The same of what catoms have told all their neighbours, if it has been left where they wrote it (Evaluator::leave_broadcasts).
    void deliver_broadcasts(const Geometry& geometry);
    bool take(u32 predicate, u32 catom, const Value* arguments, int worker = 0);
    // The same from all workers at once, for different catoms; the caller marks them.
    bool give_shared(u32 predicate, u32 catom, const Value* arguments, int worker);
    bool take_shared(u32 predicate, u32 catom, const Value* arguments, int worker);
    // Marks catoms that have been touched already for changes of this predicate.
    void mark_given(u32 predicate, std::span<const u32> catoms) { evaluator.agenda().mark_all(catoms, own_dirty(predicate)); }

    void mark(u32 catom, u64 bits) {
        evaluator.agenda().mark(catom, bits);
        touch(catom);
    }
    // The same from all workers at once.
    void mark_shared(u32 catom, u64 bits) {
        if (workers_.threads() == 1) return mark(catom, bits);
        evaluator.agenda().mark_shared(catom, bits);
        touch_shared(catom);
    }

    // From now on whoever follows learns which catoms are touched, as long as this lives: those of which users may see something else, or
    // also those that hold something else of any kind, as a snapshot has it. Those on the agenda, and those whose readers are still to be
    // told which rows have changed, may change without a word. Cost for all others: nothing.
    Touched& follow(Follows what = Follows::WhatIsSeen);
    // Something at the catom has changed outside an evaluation. Every mark says so; else whoever changes it.
    void touch(u32 catom) {
        for (const auto& follower : followers_) follower->add(catom);
    }
    bool followed() const { return !followers_.empty(); }
    void touch_shared(u32 catom) {
        for (const auto& follower : followers_) follower->add_shared(catom);
    }
    // The catoms that the evaluation which has just been may have changed.
    void touch_evaluated();

    // Everything stored for a catom, to migrate with it. Its timers stay behind, and so does the record of which rows have changed: the
    // catom is evaluated as a whole when it arrives, and sets them again.
    void pack(u32 catom, ByteWriter& out) const;
    void unpack(u32 catom, ByteReader& in);

    // What these catoms hold and why they are to be evaluated, for a snapshot, and back for those that are here.
    void save(std::span<const u32> catoms, ByteWriter& out) const;
    void load(std::span<const tuple::SavedCatom> catoms, ByteReader& in);
    // What lives only for a while: losses that are remembered, what waits for its time, actions that were asked for in the last tick.
    // Catoms go by their ids; `id` gives that of one, and `find` the catom here that this process owns, or nothing. With `only`, that of
    // the catoms for which it is true.
    void save_passing(const std::function<u64(u32)>& id, ByteWriter& out, const std::function<bool(u32)>& only = {}) const;
    void load_passing(i64 now, const std::function<std::optional<u32>(u64)>& find, ByteReader& in);
    // The actions among them, of any program: visit(id, predicate, arguments).
    static void each_saved_action(const ModuleInfo& module, ByteReader actions, const std::function<void(u64, u16, const Value*)>& visit);

    // The program's constants, which live as long as the facts that may share their lists.
    void add_parameter(tuple::Type type, Value value);
    const std::vector<Value>& parameters() const { return parameters_; }

    std::size_t bytes() const;

    tuple::Columns columns;
    eval::Evaluator evaluator;

  private:
    // here(catom): whether it is owned.
    template <class Here>
    void deliver_rows(u16 column, Here here);
    void mark_arrived(u16 column);
    u64 own_dirty(u32 predicate) const { return module_.columns[module_.predicates[predicate].column].own_dirty; }
    // A given fact is private to its catom; the planner derives from it what neighbours may read.
    void check_given(u32 predicate) const;

    const ModuleInfo& module_;
    Workers& workers_;
    std::vector<Value> parameters_;
    std::vector<u8> rows_;  // Room for give_all.
    std::vector<std::unique_ptr<Touched>> followers_;
    // What evaluations may change of what users see: these exported columns, whose changes are committed one by one; or also columns that
    // modules write to at any time.
    std::vector<bool> committed_;
    bool writes_private_ = false;
    std::vector<u32> changed_;  // Room for touch_evaluated.
};

}  // namespace meld::sim
