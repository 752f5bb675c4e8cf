#include "runtime/sim/bodies/catom_migration.h"

#include <algorithm>
#include <map>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/sim/core/migration.h"

namespace meld::sim {

namespace {

using NewOwners = std::map<std::uint64_t, int>;

// One end of a link, as sent to the process that gets the catom: the neighbour, the ports of both, and everything that the process needs to
// have the neighbour as a ghost.
struct Neighbour {
    int port = 0;
    int port_there = 0;
    int owner = 0;
    world::Vec3 position = {};
    Migrant who = {};
};

// The least number of bytes of a neighbour.
constexpr std::size_t kNeighbourBytes = 3 * sizeof(int) + sizeof(world::Vec3) + Migrant::kLeastBytes;

struct Arrival {
    Migrant who = {};
    world::Vec3 position = {}, sensed = {};
    std::vector<Neighbour> neighbours = {};
    std::vector<std::uint64_t> waits_for = {};
};

// All catoms that migrate now, on any process.
NewOwners learn_owners(Subdomain& subdomain, const DividedBodies& divided) {
    ByteWriter bytes;
    for (const auto& [body, owner] : divided.departed()) {
        bytes.write(std::uint64_t{body});
        bytes.write(owner);
    }
    NewOwners owners;
    for (const auto& from : gather_bytes(subdomain, bytes))
        for (ByteReader in(from, "owners of bodies"); !in.done();) {
            const auto id = in.read<std::uint64_t>();
            owners[id] = in.read<int>();
        }
    return owners;
}

int owner_after(const Subdomain& subdomain, const NewOwners& owners, Catom catom) {
    const auto moved = owners.find(subdomain.ensemble.id(catom));
    return moved == owners.end() ? subdomain.owner_of(catom) : moved->second;
}

std::vector<Neighbour> neighbours_of(const Subdomain& subdomain, const NewOwners& owners, Catom catom) {
    std::vector<Neighbour> found;
    subdomain.ensemble.each_link(catom, [&](int port, Catom other) {
        found.push_back({.port = port,
                         .port_there = subdomain.ensemble.port_there(catom, port),
                         .owner = owner_after(subdomain, owners, other),
                         .position = subdomain.ensemble.position(other),
                         .who = {subdomain.ensemble.id(other), {}}});
    });
    return found;
}

// The catoms with which each migrating catom waits to be linked, in order.
using Waits = std::map<std::uint64_t, std::vector<std::uint64_t>>;

Waits waits_of(const DividedBodies& divided, const ContactLinks& links) {
    Waits waits;
    for (const auto& [body, owner] : divided.departed()) waits[body];
    for (const auto& [first, second] : links.waiting()) {
        if (const auto found = waits.find(first); found != waits.end()) found->second.push_back(second);
        if (const auto found = waits.find(second); found != waits.end()) found->second.push_back(first);
    }
    return waits;
}

void pack(const Subdomain& subdomain, const NewOwners& owners, const std::vector<std::uint64_t>& waits_for, Catom catom, ByteWriter& out) {
    pack_migrant(subdomain, catom, kCatomOwned).write(out);
    out.write(subdomain.ensemble.position(catom));
    out.write(subdomain.sensed_position(catom));
    const std::vector<Neighbour> neighbours = neighbours_of(subdomain, owners, catom);
    out.write_count(neighbours.size());
    for (const Neighbour& n : neighbours) {
        out.write(n.port);
        out.write(n.port_there);
        out.write(n.owner);
        out.write(n.position);
        pack_migrant(subdomain, *subdomain.ensemble.find(n.who.id), kCatomGhost).write(out);
    }
    out.write_count(waits_for.size());
    for (const std::uint64_t other : waits_for) out.write(other);
}

Arrival unpack(ByteReader& in) {
    Arrival a;
    a.who = Migrant::read(in);
    a.position = in.read<world::Vec3>();
    a.sensed = in.read<world::Vec3>();
    a.neighbours.resize(in.read_count(kNeighbourBytes));
    for (Neighbour& n : a.neighbours) {
        n.port = in.read<int>();
        n.port_there = in.read<int>();
        n.owner = in.read<int>();
        n.position = in.read<world::Vec3>();
        n.who = Migrant::read(in);
    }
    a.waits_for.resize(in.read_count(sizeof(std::uint64_t)));
    for (std::uint64_t& other : a.waits_for) other = in.read<std::uint64_t>();
    return a;
}

// A catom of ours that has migrated stays as a ghost if a catom that stays touches it.
void depart(Subdomain& subdomain, const NewOwners& owners, std::uint64_t id, int owner) {
    const Catom catom = *subdomain.ensemble.find(id);
    MELD_EXPECT(subdomain.owned(catom) && owner != subdomain.comm.process(), "catom @{} goes to process {}", id, owner);
    std::vector<Neighbour> staying = neighbours_of(subdomain, owners, catom);
    std::erase_if(staying, [&](const Neighbour& n) {
        return n.owner != subdomain.comm.process() || !subdomain.owned(*subdomain.ensemble.find(n.who.id));
    });
    const world::Vec3 position = subdomain.ensemble.position(catom);
    const Migrant who = pack_migrant(subdomain, catom, kCatomGhost);
    take_out(subdomain, catom);
    if (staying.empty()) return;
    const Catom ghost = add_migrant_freely(subdomain, who, position, owner);
    for (const Neighbour& n : staying) subdomain.restore_link(ghost, n.port, *subdomain.ensemble.find(n.who.id), n.port_there);
}

void arrive(Subdomain& subdomain, const Arrival& a) {
    if (const std::optional<Catom> ghost = subdomain.ensemble.find(a.who.id)) {
        MELD_CHECK(!subdomain.owned(*ghost), "catom @{} comes to the process that has it", a.who.id);
        take_out(subdomain, *ghost);
    }
    const Catom catom = add_migrant_freely(subdomain, a.who, a.position, subdomain.comm.process());
    if (subdomain.senses_positions()) subdomain.sense_position(catom, a.sensed);
}

void connect(Subdomain& subdomain, const Arrival& a) {
    const Catom catom = *subdomain.ensemble.find(a.who.id);
    MELD_EXPECT(subdomain.owned(catom), "catom @{} is not ours", a.who.id);
    for (const Neighbour& n : a.neighbours) {
        std::optional<Catom> other = subdomain.ensemble.find(n.who.id);
        if (!other) other = add_migrant_freely(subdomain, n.who, n.position, n.owner);
        if (!subdomain.ensemble.linked(catom, n.port)) subdomain.restore_link(catom, n.port, *other, n.port_there);
        subdomain.mark(*other, kDirtyLinks);
    }
}

}  // namespace

void take_out(Subdomain& subdomain, Catom catom) {
    std::vector<Catom> others;
    subdomain.each_neighbour(catom, [&](Catom other) { others.push_back(other); });
    subdomain.remove_freely(catom);
    for (const Catom other : others) {
        subdomain.mark(other, kDirtyLinks);
        forget_if_lonely(subdomain, other);
    }
}

void migrate_catoms(Subdomain& subdomain, const DividedBodies& divided, ContactLinks& links) {
    const NewOwners owners = learn_owners(subdomain, divided);
    if (owners.empty()) return;
    std::vector<ByteWriter> out(static_cast<std::size_t>(subdomain.comm.processes()));
    const Waits waits = waits_of(divided, links);
    for (const auto& [body, owner] : divided.departed())
        pack(subdomain, owners, waits.at(body), *subdomain.ensemble.find(body), out[static_cast<std::size_t>(owner)]);
    std::vector<Arrival> arrivals;
    for (const comm::Packet& packet : exchange_bytes(subdomain, out))
        for (ByteReader in(packet.bytes, "catoms that change processes"); !in.done();) arrivals.push_back(unpack(in));

    for (const auto& [body, owner] : divided.departed()) depart(subdomain, owners, body, owner);
    for (const auto& [id, owner] : owners)
        if (const std::optional<Catom> ghost = subdomain.ensemble.find(id)) subdomain.set_owner(*ghost, owner);
    for (const Arrival& a : arrivals) arrive(subdomain, a);
    for (const Arrival& a : arrivals) connect(subdomain, a);
    MELD_ENSURE(std::ranges::all_of(owners,
                                    [&](const auto& moved) {
                                        const std::optional<Catom> catom = subdomain.ensemble.find(moved.first);
                                        return !catom || subdomain.owner_of(*catom) == moved.second;
                                    }),
                "a catom has not followed its body");
    std::vector<ContactLinks::Pair> waiting;
    for (const Arrival& a : arrivals)
        for (const std::uint64_t other : a.waits_for)
            waiting.push_back(
                {static_cast<physics::BodyId>(std::min(a.who.id, other)), static_cast<physics::BodyId>(std::max(a.who.id, other))});
    links.change_hands(subdomain, waiting);
}

}  // namespace meld::sim
