#include "runtime/sim/core/part_state.h"

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/tuple/facts.h"

namespace meld::sim {

namespace {

bool reads_places_of(const ModuleInfo& module) {
    for (const char* name : {"position", "at"})
        for (const std::size_t arity : {std::size_t{1}, std::size_t{3}}) {
            const std::optional<u32> p = tuple::find_sensed(module, name, arity);
            if (p && module.predicates[*p].storage == Storage::World && module.predicates[*p].read) return true;
        }
    return false;
}

}  // namespace

PartState::PartState(const ModuleInfo& module_info, const world::World& the_world, const world::Target& target,
                     comm::Communicator& communicator, int threads)
    : module(module_info),
      world(the_world),
      comm(communicator),
      lattice(the_world.lattice),
      ensemble(lattice, target),
      workers(threads),
      columns(module_info, threads),
      evaluator(module_info, columns, workers,
                [this](u32 catom, double out[3]) {
                    const world::Vec3 at = sensed_position(catom);
                    for (std::size_t i = 0; i < 3; ++i) out[i] = at[i];
                }),
      reads_places(reads_places_of(module_info)),
      outgoing_(static_cast<std::size_t>(threads), std::vector<std::vector<Export>>(static_cast<std::size_t>(communicator.parts()))),
      packets_(static_cast<std::size_t>(communicator.parts())) {
    if (!world.is_free()) return;
    ensemble.set_free(world.target ? [shape = *world.target](const world::Vec3& at) { return shape.contains(at); }
                                   : std::function<bool(const world::Vec3&)>());
}

PartState::~PartState() {
    for (u32 i = 0; i < parameters.size(); ++i) columns.lists().release({module.types, module.parameters[i].deep}, parameters[i], 0);
}

void PartState::refresh() {
    abi.geometry = ensemble.geometry();
    abi.columns = columns.pointers();
    abi.changes = columns.changes().pointers();
    if (halo) halo->prepare();
}

bool PartState::give(u32 predicate, Catom catom, const Value* arguments) {
    // What is given is private to its catom; the planner derives from it what neighbours may read.
    const u16 column = module.predicates[predicate].column;
    MELD_CHECK(column != kNone16 && !module.columns[column].exported, "{} is no given predicate", module.predicates[predicate].name);
    if (!tuple::give_fact(module, columns, predicate, catom, arguments, 0)) return false;
    mark(catom, module.columns[column].own_dirty);
    return true;
}

void PartState::give_all(u32 predicate, Catom catom, std::vector<const Value*>& facts) {
    const u16 column = module.predicates[predicate].column;
    if (module.predicates[predicate].storage != Storage::Rows) {
        for (const Value* arguments : facts) give(predicate, catom, arguments);
    } else if (tuple::give_facts(module, columns, predicate, catom, facts, delivery_.rows, 0)) {
        mark(catom, module.columns[column].own_dirty);
    }
}

bool PartState::take(u32 predicate, Catom catom, const Value* arguments) {
    if (!tuple::take_fact(module, columns, predicate, catom, arguments, 0)) return false;
    mark(catom, module.columns[module.predicates[predicate].column].own_dirty);
    return true;
}

Catom PartState::add_catom(std::uint64_t id, Cell cell, CatomState state) {
    const Catom catom = ensemble.add(id, cell, state);
    columns.resize(ensemble.index_count());
    evaluator.agenda().resize(ensemble.index_count());
    if (state == kCatomOwned) ensemble.surround(*ensemble.find_slot(lattice.brick_of(cell)));
    mark_around(cell, kDirtyLinks);
    return catom;
}

void PartState::remove_catom(Catom catom) {
    const Cell cell = ensemble.cell(catom);
    columns.clear(catom, 0);
    evaluator.agenda().forget(catom);
    evaluator.tombstones().forget(catom);
    evaluator.timers().forget(abi.now, catom);
    ensemble.remove(catom);
    mark_around(cell, kDirtyLinks);
}

// What it waits for is forgotten and set again, as where a catom moves to another part: how often it is looked at must not
// depend on where it came from.
void PartState::move_catom(Catom catom, Cell to) {
    mark_around(ensemble.cell(catom), kDirtyLinks);
    ensemble.move(catom, to);
    ensemble.surround(*ensemble.find_slot(lattice.brick_of(to)));
    mark_around(to, kDirtyLinks);
    evaluator.timers().forget(abi.now, catom);
    mark(catom, kDirtyWake | kDirtyLinks | kDirtyPlace);
}

void PartState::mark_around(Cell cell, u64 bits) {
    for (int port = 0; port < lattice.ports(); ++port)
        if (const std::optional<Catom> other = ensemble.at(lattice.neighbour(cell, port))) mark(*other, bits);
}

void PartState::mark_neighbours(Catom catom, u64 bits) {
    if (ensemble.is_free()) {
        for (int port = 0; port < kMaxPorts; ++port)
            if (const std::optional<Catom> other = ensemble.linked(catom, port)) mark(*other, bits);
    } else {
        mark_around(ensemble.cell(catom), bits);
    }
}

Catom PartState::add_freely(std::uint64_t id, const world::Vec3& position, CatomState state, int owner) {
    const Catom catom = ensemble.add_at(id, position, state);
    const std::size_t count = ensemble.index_count();
    columns.resize(count);
    evaluator.agenda().resize(count);
    if (reads_places) {
        sensed_positions.resize(count);
        sensed_positions[catom] = position;
    }
    if (!alone()) {
        owners.resize(count);
        owners[catom] = owner;
    }
    return catom;
}

void PartState::remove_freely(Catom catom) {
    columns.clear(catom, 0);
    evaluator.agenda().forget(catom);
    evaluator.tombstones().forget(catom);
    evaluator.timers().forget(abi.now, catom);
    ensemble.remove(catom);
}

int PartState::owner_of(Catom catom) const {
    if (alone()) return comm.part();
    return ensemble.is_free() ? owners[catom] : halo->owner(ensemble.cell(catom));
}

void PartState::pack_catom(Catom catom, ByteWriter& out) const {
    columns.pack(catom, tuple::Columns::Which::All, out);
    out.write(evaluator.agenda().dirty(catom));
    const auto* losses = evaluator.tombstones().of(catom);
    out.write_count(losses == nullptr ? 0 : losses->size());
    if (losses != nullptr)
        for (const auto& loss : *losses) out.write(loss);
}

void PartState::unpack_catom(Catom catom, ByteReader& in) {
    columns.unpack(catom, tuple::Columns::Which::All, in, 0);
    // Timers stay behind, and so does which rows have changed: the catom is looked at now, as a whole, and sets them again.
    mark(catom, in.read<u64>() | kDirtyWake | kDirtyLinks);
    std::vector<eval::Tombstones::Entry> losses(in.read_count(sizeof(eval::Tombstones::Entry)));
    for (auto& loss : losses) loss = in.read<eval::Tombstones::Entry>();
    evaluator.tombstones().restore(catom, std::move(losses));
}

std::size_t PartState::bytes() const {
    return ensemble.bytes() + columns.bytes() + evaluator.agenda().bytes() + motion_bytes +
           sensed_positions.capacity() * sizeof(world::Vec3) + owners.capacity() * sizeof(owners[0]);
}

}  // namespace meld::sim
