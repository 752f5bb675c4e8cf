// The fact store in a snapshot.
#include "runtime/base/assert.h"
#include "runtime/sim/catoms/fact_store.h"

namespace meld::sim {

void FactStore::save(std::span<const u32> catoms, ByteWriter& out) const {
    columns.save(catoms, out);
    // Mostly no catom is on the agenda.
    ByteWriter awake;
    for (u32 i = 0; i < catoms.size(); ++i) {
        const u64 dirty = evaluator.agenda().dirty(catoms[i]);
        if (dirty == 0) continue;
        awake.write(i);
        awake.write(static_cast<u32>(dirty));
    }
    out.write_block(awake.view());
}

void FactStore::load(std::span<const tuple::SavedCatom> catoms, ByteReader& in) {
    columns.load(catoms, in);
    for (const auto& follower : followers_) follower->add_all();
    for (ByteReader awake(in.read_block(), "the agenda of a snapshot"); !awake.done();) {
        const auto at = awake.read<u32>(), dirty = awake.read<u32>();
        if (at < catoms.size() && catoms[at].owned && dirty != 0) mark(catoms[at].catom, dirty);
    }
}

void FactStore::save_passing(const std::function<u64(u32)>& id, ByteWriter& out, const std::function<bool(u32)>& only) const {
    const auto saved = [&](u32 catom) { return !only || only(catom); };
    ByteWriter losses, undefined, marks, groups, actions;
    evaluator.tombstones().each([&](u32 catom, const std::vector<eval::Tombstones::Entry>& entries) {
        if (!saved(catom)) return;
        losses.write(id(catom));
        losses.write_count(entries.size());
        for (const auto& entry : entries) losses.write(entry);
    });
    evaluator.undefined().each([&](u32 catom, const eval::Undefined::Entries& entries) {
        if (!saved(catom)) return;
        undefined.write(id(catom));
        undefined.write_count(entries.size());
        for (const auto& entry : entries) undefined.write(entry);
    });
    evaluator.timers().each(
        [&](i64 tick, u32 catom, u32 bits) {
            if (!saved(catom)) return;
            marks.write(tick);
            marks.write(id(catom));
            marks.write(bits);
        },
        [&](i64 tick, u32 catom, u16 column, const u8* row) {
            if (!saved(catom)) return;
            groups.write(tick);
            groups.write(id(catom));
            groups.write(column);
            groups.write_bytes(row, module_.columns[column].row_bytes);
        },
        [&](i64 tick) {
            if (only) return;
            // A mark of nothing.
            marks.write(tick);
            marks.write(u64{0});
            marks.write(u32{0});
        });
    for (const eval::Action& action : evaluator.actions()) {
        if (!saved(action.catom)) continue;
        actions.write(id(action.catom));
        actions.write(action.predicate);
        const PredicateInfo& p = module_.predicates[action.predicate];
        for (u32 i = 0; i < p.arity; ++i) tuple::pack(tuple::type_of(module_, p.fields[i]), action.arguments[i], actions);
    }
    for (const ByteWriter* each : {&losses, &undefined, &marks, &groups, &actions}) out.write_block(each->view());
}

void FactStore::load_passing(i64 now, const std::function<std::optional<u32>(u64)>& find, ByteReader& in) {
    for (ByteReader losses(in.read_block(), "the losses of a snapshot"); !losses.done();) {
        const std::optional<u32> catom = find(losses.read<u64>());
        std::vector<eval::Tombstones::Entry> entries(losses.read_count(sizeof(eval::Tombstones::Entry)));
        for (auto& entry : entries) entry = losses.read<eval::Tombstones::Entry>();
        if (catom) evaluator.tombstones().restore(*catom, entries);
    }
    for (ByteReader undefined(in.read_block(), "the undefined derivations of a snapshot"); !undefined.done();) {
        const std::optional<u32> catom = find(undefined.read<u64>());
        eval::Undefined::Entries entries(undefined.read_count(sizeof(eval::Undefined::Entry)));
        for (auto& entry : entries) entry = undefined.read<eval::Undefined::Entry>();
        if (catom) evaluator.undefined().restore(*catom, std::move(entries));
    }
    for (ByteReader marks(in.read_block(), "the timers of a snapshot"); !marks.done();) {
        const auto tick = marks.read<i64>();
        const std::optional<u32> catom = find(marks.read<u64>());
        const auto bits = marks.read<u32>();
        if (bits == 0 && tick > now) evaluator.timers().add_idle(tick);
        if (catom && bits != 0) evaluator.timers().add(now, tick, *catom, bits);
    }
    for (ByteReader groups(in.read_block(), "the timers of groups of a snapshot"); !groups.done();) {
        const auto tick = groups.read<i64>();
        const std::optional<u32> catom = find(groups.read<u64>());
        const auto column = groups.read<u16>();
        if (column >= module_.column_count) return;
        const std::span<const std::byte> row = groups.read_bytes(module_.columns[column].row_bytes);
        if (catom) evaluator.timers().add_group(now, tick, *catom, column, reinterpret_cast<const u8*>(row.data()), row.size());
    }
    each_saved_action(module_, {in.read_block(), "the actions of a snapshot"}, [&](u64 id, u16 predicate, const Value* arguments) {
        if (const std::optional<u32> catom = find(id)) evaluator.restore_action(*catom, predicate, arguments);
    });
}

void FactStore::each_saved_action(const ModuleInfo& module, ByteReader actions, const std::function<void(u64, u16, const Value*)>& visit) {
    tuple::Arena lists;
    std::vector<Value> arguments;
    while (!actions.done()) {
        const auto id = actions.read<u64>();
        const auto predicate = actions.read<u16>();
        if (predicate >= module.predicate_count) return;
        const PredicateInfo& p = module.predicates[predicate];
        arguments.resize(p.arity);
        for (u32 i = 0; i < p.arity; ++i) arguments[i] = tuple::unpack(tuple::type_of(module, p.fields[i]), actions, lists);
        visit(id, predicate, arguments.data());
    }
}

}  // namespace meld::sim
