#include "runtime/sim/core/subdomain.h"

#include <algorithm>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/sim/core/created_nodes.h"
#include "runtime/sim/core/setup/setup.h"

namespace meld::sim {

Subdomain::Subdomain(const ModuleInfo& module_info, const world::World& the_world, const world::Target& target,
                     comm::Communicator& communicator, int threads)
    : module(module_info),
      program_actions(module_info),
      world(the_world),
      comm(communicator),
      workers(threads),
      members_(module_info, the_world, target, communicator),
      facts_(module_info, workers, [this](u32 catom, double out[3]) {
          const world::Vec3 at = members_.sensed_position(catom);
          for (std::size_t i = 0; i < 3; ++i) out[i] = at[i];
      }) {
    abi_.alone = alone();
    if (module.finds_ways && world.is_graph()) {
        const bool anywhere =
            world.network.reach.value_or(module.makes_nodes ? world::Reach::Any : world::Reach::Links) == world::Reach::Any;
        routes_.emplace(anywhere, members_, communicator);
        facts_.evaluator.find_ways([this](u32 catom, u64 goal) { return routes_->next_hop(catom, goal); }, anywhere);
    }
    if (module.makes_nodes && world.is_graph())
        facts_.evaluator.make_nodes([this](u32 catom, u32 n) { return Births::number(members_, catom, n); });
    if (!world.apart()) return;
    network_.emplace(module, world, members_, facts_, abi_);
    const auto before_commit = [this, changing = std::vector<eval::Change>()]() mutable {
        changing.clear();
        facts_.evaluator.add_changes(changing);
        network_->before_change(tick(), changing);
        refresh();
    };
    if (world.clock.gives_turns()) {
        turns_.emplace(world.clock.kind, members_, facts_, communicator);
        facts_.evaluator.read_apart(
            before_commit, [this](u32 catom) { return turns_->acts(catom); }, [this](u32 mailbox) { return network_->reader(mailbox); });
        return;
    }
    // A call for each catom that is awake, so none where all act.
    facts_.evaluator.read_apart(
        before_commit,
        world.clock.synchronous() ? std::function<bool(u32)>() : [this](u32 catom) { return network_->acts(tick(), catom); });
}

Result<void> Subdomain::populate(std::optional<BrickCounts> counted) { return Setup(*this).run(std::move(counted)); }

void Subdomain::refresh() {
    abi_.geometry = members_.ensemble.geometry();
    abi_.columns = facts_.columns.pointers();
    abi_.changes = facts_.columns.changes().pointers();
    if (members_.halo) members_.halo->prepare();
    MELD_ENSURE(facts_.columns.count() >= ensemble.index_count(), "columns of {} catoms, and there are {}", facts_.columns.count(),
                ensemble.index_count());
}

void Subdomain::share_routes() {
    if (!routes_) return;
    ByteWriter mine;
    routes_->report(mine);
    if (alone()) {
        ByteReader in(mine.view(), "nodes and links that have changed");
        routes_->take(0, in);
    } else {
        const auto all = comm.allgather_any(mine.view());
        for (std::size_t process = 0; process < all.size(); ++process) {
            ByteReader in(all[process], "nodes and links that have changed");
            routes_->take(static_cast<int>(process), in);
        }
    }
    routes_->settle();
}

void Subdomain::mark_around(Cell cell, u64 bits) {
    for (int port = 0; port < lattice.ports(); ++port)
        if (const std::optional<Catom> other = ensemble.at(lattice.neighbour(cell, port))) mark(*other, bits);
}

void Subdomain::mark_neighbours(Catom catom, u64 bits) {
    each_neighbour(catom, [&](Catom other) { mark(other, bits); });
}

Catom Subdomain::add_catom(std::uint64_t id, Cell cell, CatomState state) {
    MELD_EXPECT(!ensemble.is_free() && !ensemble.at(cell), "catom @{} in a cell that is full", id);
    const Catom catom = members_.ensemble.add(id, cell, state);
    facts_.resize(ensemble.index_count());
    facts_.touch(catom);
    if (state == kCatomOwned) members_.ensemble.surround(*ensemble.find_slot(lattice.brick_of(cell)));
    mark_around(cell, kDirtyLinks);
    return catom;
}

void Subdomain::remove_catom(Catom catom) {
    MELD_EXPECT(!ensemble.is_free() && ensemble.state(catom) != kCatomFree, "catom {}", catom);
    const Cell cell = ensemble.cell(catom), tail = ensemble.tail(catom);
    facts_.forget(catom, ensemble.id(catom));
    if (turns_) turns_->forget(ensemble.id(catom));
    members_.ensemble.remove(catom);
    mark_around(cell, kDirtyLinks);
    if (tail != cell) mark_around(tail, kDirtyLinks);
}

bool Subdomain::hangs(std::uint64_t id) const { return std::ranges::binary_search(status_.hung, id); }

void Subdomain::fall_silent(std::uint64_t id) {
    if (hangs(id)) return;
    status_.hung.insert(std::ranges::lower_bound(status_.hung, id), id);
    facts_.evaluator.leave_out([this](u32 catom) { return hangs(ensemble.id(catom)); });
}

void Subdomain::wake_up(std::uint64_t id) {
    if (!hangs(id)) return;
    std::erase(status_.hung, id);
    if (status_.hung.empty()) facts_.evaluator.leave_out({});
}

void Subdomain::restart(Catom catom) {
    MELD_EXPECT(ensemble.keeps_links(), "catom {} in a world without links", catom);
    const std::uint64_t id = ensemble.id(catom);
    members_.ensemble.links().renew(catom);
    if (network_) each_neighbour(catom, [&](Catom other) { network_->forget_loss(id, ensemble.id(other)); });
    mark_neighbours(catom, kDirtyLinks);
    facts_.forget(catom, id);
    if (turns_) turns_->forget(id);
    if (owned(catom)) mark(catom, kDirtyBirths);
}

void Subdomain::move_catom(Catom catom, Cell to) {
    MELD_EXPECT(owned(catom) && !ensemble.at(to), "catom {}", catom);
    mark_around(ensemble.cell(catom), kDirtyLinks);
    members_.ensemble.move(catom, to);
    members_.ensemble.surround(*ensemble.find_slot(lattice.brick_of(to)));
    mark_around(to, kDirtyLinks);
    facts_.wake_moved(catom);
}

void Subdomain::reshape_catom(Catom catom, Cell head, Cell tail) {
    const auto mark_beside = [&] { ensemble.each_beside(catom, [&](Catom other) { mark(other, kDirtyLinks); }); };
    mark_beside();
    members_.ensemble.reshape(catom, head, tail);
    if (owned(catom)) members_.ensemble.surround_amoebot(catom);
    mark_beside();
    if (owned(catom)) facts_.wake_moved(catom);
}

std::uint64_t Subdomain::take_ids(std::uint64_t count) { return std::exchange(members_.next_id, members_.next_id + count); }

Catom Subdomain::add_freely(std::uint64_t id, const world::Vec3& position, CatomState state, int owner) {
    const Catom catom = members_.add_freely(id, position, state, owner);
    facts_.resize(ensemble.index_count());
    facts_.touch(catom);
    return catom;
}

void Subdomain::remove_freely(Catom catom) {
    MELD_EXPECT(ensemble.is_free() && ensemble.state(catom) != kCatomFree, "catom {}", catom);
    facts_.forget(catom, ensemble.id(catom));
    members_.ensemble.remove(catom);
}

void Subdomain::move_node(graph::Node node, const world::Vec3& to) {
    members_.nodes->move(node, to);
    const std::optional<Catom> catom = ensemble.find(nodes().id(node));
    if (!catom) return;
    members_.ensemble.place(*catom, to);
    if (senses_positions()) sense_position(*catom, to);
}

void Subdomain::pack_catom(Catom catom, CatomState there, ByteWriter& out) const {
    MELD_EXPECT(ensemble.state(catom) != kCatomFree && (owned(catom) || there == kCatomGhost), "catom {}", catom);
    if (there != kCatomOwned) return columns.pack(catom, tuple::Columns::Which::Exported, out);
    facts_.pack(catom, out);
    if (turns_) turns_->pack(ensemble.id(catom), out);
}

void Subdomain::unpack_catom(Catom catom, ByteReader& in) {
    MELD_EXPECT(ensemble.state(catom) != kCatomFree, "catom {}", catom);
    if (!owned(catom)) return facts_.columns.unpack(catom, tuple::Columns::Which::Exported, in, 0);
    facts_.unpack(catom, in);
    if (turns_) turns_->unpack(ensemble.id(catom), in);
}

void Subdomain::link(Catom a, int port_of_a, Catom b, int port_of_b) {
    members_.ensemble.link(a, port_of_a, b, port_of_b);
    note_change();
    for (const Catom catom : {a, b}) mark(catom, kDirtyLinks);
}

void Subdomain::unlink(Catom a, Catom b) {
    const std::optional<int> port = ensemble.port_towards(a, b);
    MELD_CHECK(port.has_value(), "catoms @{} and @{} are not linked", ensemble.id(a), ensemble.id(b));
    members_.ensemble.unlink(a, *port);
    note_change();
    for (const Catom catom : {a, b}) mark(catom, kDirtyLinks);
}

}  // namespace meld::sim
