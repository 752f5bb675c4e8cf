#include "runtime/sim/state/hand_over.h"

#include <algorithm>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/comm/transport/packets.h"
#include "runtime/sim/core/setup/setup.h"
#include "runtime/sim/state/cell_places.h"
#include "runtime/sim/state/placed_chunk.h"
#include "runtime/sim/state/share.h"

namespace meld::sim {

namespace {

// The owner of the brick itself.
int owner_of(const std::vector<partition::Halo::Side>& sides) {
    for (const partition::Halo::Side& side : sides)
        if (side.dx == 0 && side.dy == 0 && side.dz == 0) return side.process;
    return -1;
}

// Who owns the cell of a brick or reads it, in no order; each once.
void find_listeners(const partition::Halo& halo, const std::vector<partition::Halo::Side>& sides, std::uint32_t cell,
                    std::vector<int>& listeners) {
    listeners.clear();
    for (const partition::Halo::Side& side : sides)
        if (halo.near(side, cell) && std::ranges::find(listeners, side.process) == listeners.end()) listeners.push_back(side.process);
}

}  // namespace

bool HandOver::possible(const Subdomain& subdomain, const Modules& modules) {
    return !subdomain.alone() && !subdomain.ensemble.is_free() && !subdomain.ensemble.keeps_links() && !subdomain.world.apart() &&
           std::ranges::all_of(modules, [](const NamedModule& each) { return each.module->divides_anew(); });
}

std::uint64_t HandOver::run(const partition::Partition& next) {
    Membership& members = subdomain_.members_;
    const int me = subdomain_.comm.process();
    subdomain_.refresh();
    partition::Halo then(members.ensemble, next, me, Setup::reach(subdomain_.world, subdomain_.program_actions));
    then.prepare();
    const Plan plan = this->plan(then, next);

    std::vector<ByteWriter> bytes(plan.to.size());
    for (std::size_t process = 0; process < bytes.size(); ++process)
        if (!plan.to[process].empty()) pack(plan, static_cast<int>(process), bytes[process]);
    std::vector<comm::Packet> kept;
    const auto own = static_cast<std::size_t>(me);
    if (!bytes[own].empty()) kept.push_back({me, bytes[own].take()});

    take_out(plan);
    *members.partition = next;
    members.halo.emplace(members.ensemble, *members.partition, me, Setup::reach(subdomain_.world, subdomain_.program_actions));
    std::vector<comm::Packet> packets = subdomain_.comm.exchange(comm::take_packets(bytes));
    for (comm::Packet& each : kept) packets.push_back(std::move(each));
    take_in(packets);
    codes_.follow(subdomain_);
    return plan.leave.size();
}

HandOver::Plan HandOver::plan(const partition::Halo& then, const partition::Partition& next) const {
    const Membership& members = subdomain_.members_;
    const world::Ensemble& ensemble = members.ensemble;
    const int me = subdomain_.comm.process();
    Plan plan{.to = std::vector<std::vector<Catom>>(static_cast<std::size_t>(next.processes())),
              .leave = {},
              .taken_out = {},
              .owner = std::vector<int>(ensemble.index_count(), -1)};
    const auto& geometry = subdomain_.geometry();
    std::vector<int> before, after;
    for (world::Slot slot = 1; slot <= ensemble.brick_count(); ++slot) {
        if (members.halo->inside(slot) && then.inside(slot)) continue;
        const Cell brick = ensemble.brick(slot);
        const std::vector<partition::Halo::Side> was = members.halo->sides(brick), will = then.sides(brick);
        const auto same = [](const auto& a, const auto& b) { return a.process == b.process; };
        if (std::ranges::equal(was, will, same)) continue;
        const int owner = owner_of(will);
        for (std::uint32_t cell = 0; cell < kBrickCells; ++cell) {
            const std::int32_t at = geometry.cell_catom[(std::size_t{slot} << kBrickCellBits) + cell];
            if (at < 0) continue;
            const auto catom = static_cast<Catom>(at);
            find_listeners(then, will, cell, after);
            const bool listens = std::ranges::find(after, me) != after.end();
            if (!subdomain_.owned(catom)) {
                if (owner == me || !listens) plan.taken_out.push_back(catom);
                continue;
            }
            find_listeners(*members.halo, was, cell, before);
            for (const int process : after) {
                const bool knows = process == me ? owner == me : std::ranges::find(before, process) != before.end();
                if (!knows || (process == owner && owner != me)) plan.to[static_cast<std::size_t>(process)].push_back(catom);
            }
            if (owner == me) continue;
            plan.owner[catom] = owner;
            plan.leave.push_back(catom);
            plan.taken_out.push_back(catom);
        }
    }
    return plan;
}

// Chunks of places and of what is kept, and what lives only for a while of those that the process will own.
void HandOver::pack(const Plan& plan, int process, ByteWriter& out) const {
    const std::vector<Catom>& all = plan.to[static_cast<std::size_t>(process)];
    out.write_count((all.size() + kMostCatomsOfAChunk - 1) / kMostCatomsOfAChunk);
    for (std::size_t from = 0; from < all.size(); from += kMostCatomsOfAChunk) {
        const auto catoms = std::span(all).subspan(from, std::min<std::size_t>(kMostCatomsOfAChunk, all.size() - from));
        const std::size_t places = out.begin_block();
        CellPlaces::save(subdomain_.ensemble, catoms, out);
        out.end_block(places);
        const std::size_t held = out.begin_block();
        subdomain_.facts_.save(catoms, out);
        for (const NamedModule& each : modules_) {
            const std::size_t begun = out.begin_block();
            each.module->save_catoms(subdomain_, catoms, out);
            out.end_block(begun);
        }
        out.end_block(held);
    }
    subdomain_.facts_.save_passing([&](u32 catom) { return subdomain_.ensemble.id(catom); }, out,
                                   [&](u32 catom) { return plan.owner[catom] == process; });
}

void HandOver::take_out(const Plan& plan) {
    for (const NamedModule& each : modules_) each.module->leave(subdomain_, plan.leave);
    subdomain_.facts_.evaluator.drop_actions([&](u32 catom) { return plan.owner[catom] >= 0; });
    for (const Catom catom : plan.taken_out) {
        subdomain_.facts_.forget(catom, subdomain_.ensemble.id(catom));
        subdomain_.members_.ensemble.remove(catom);
    }
}

void HandOver::take_in(std::span<const comm::Packet> packets) {
    constexpr const char* kWhat = "catoms from another process";
    Membership& members = subdomain_.members_;
    struct Received {
        PlacedChunk placed;
        BlockView held;
    };
    std::vector<Received> chunks;
    std::vector<ByteReader> rests;
    for (const comm::Packet& packet : packets) {
        ByteReader in(packet.bytes, kWhat);
        for (auto left = in.read_count(2 * sizeof(std::uint64_t)); left > 0; --left) {
            ByteReader places(in.read_block(), kWhat);
            const Result<CellPlaces> all = CellPlaces::read(places);
            MELD_CHECK(all.has_value(), "{}", all.error().message());
            Received& chunk = chunks.emplace_back();
            const Result<void> placed = place_on_cells(members, *all, subdomain_.comm.process(), chunk.placed);
            MELD_CHECK(placed.has_value(), "{}", placed.error().message());
            chunk.held = in.read_block();
        }
        rests.push_back(in);
    }
    Setup(subdomain_).surround();
    subdomain_.facts_.resize(subdomain_.ensemble.index_count());
    subdomain_.refresh();
    std::vector<tuple::SavedCatom> found;
    for (const Received& chunk : chunks) {
        chunk.placed.list(found);
        ByteReader in(chunk.held, kWhat);
        subdomain_.facts_.load(found, in);
        for (const NamedModule& each : modules_) {
            ByteReader own(in.read_block(), kWhat);
            each.module->load_catoms(subdomain_, found, own);
            MELD_CHECK(own.done(), "{} leaves {} bytes of what it kept for catoms", each.name, own.left());
        }
        MELD_CHECK(in.done(), "{} bytes of catoms are left", in.left());
    }
    const auto owned = [&](u64 id) -> std::optional<u32> {
        const std::optional<Catom> catom = subdomain_.ensemble.find(id);
        return catom && subdomain_.owned(*catom) ? catom : std::nullopt;
    };
    for (ByteReader& in : rests) {
        subdomain_.facts_.load_passing(subdomain_.tick(), owned, in);
        MELD_CHECK(in.done(), "{} bytes of catoms are left", in.left());
    }
    subdomain_.facts_.evaluator.order_actions(subdomain_.ensemble.geometry());
    subdomain_.refresh();
}

}  // namespace meld::sim
