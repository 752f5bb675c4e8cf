#include "scene.h"

#include "runtime/base/random.h"

namespace meld::reference {

using check::WorldSource;

namespace {

// The facts of one catom; the target is empty in every case.
std::vector<Row> sensed(WorldSource source, const world::Lattice& lattice, const std::map<world::Cell, std::uint64_t>& at, world::Cell cell,
                        std::int64_t id, const std::vector<Link>& links, std::int64_t tick) {
    const Value me = value_of(id);
    switch (source) {
        case WorldSource::NeighborCount:
            return {{me, value_of(static_cast<std::int64_t>(links.size()))}};
        case WorldSource::Vacant: {
            std::vector<Row> rows;
            for (int port = 0; port < lattice.ports(); ++port)
                if (!at.contains(lattice.neighbour(cell, port))) rows.push_back({me, value_of(std::int64_t{port})});
            return rows;
        }
        case WorldSource::Cell:
            return {{me, value_of(std::int64_t{cell.x}), value_of(std::int64_t{cell.y}), value_of(std::int64_t{cell.z})}};
        case WorldSource::Position:
        case WorldSource::PositionVector: {
            const world::Vec3 at = lattice.position(cell);
            if (source == WorldSource::PositionVector) return {{me, value_of(Values{value_of(at[0]), value_of(at[1]), value_of(at[2])})}};
            return {{me, value_of(at[0]), value_of(at[1]), value_of(at[2])}};
        }
        case WorldSource::Id:
            return {{me, value_of(id)}};
        case WorldSource::Tick:
            return {{me, value_of(tick)}};
        default:
            return {};
    }
}

// Its tables take longer to make than all the rest of a scene.
const world::Lattice& lattice_of(world::LatticeKind kind) {
    static std::map<world::LatticeKind, world::Lattice> made;
    return made.try_emplace(kind, kind).first->second;
}

}  // namespace

std::uint64_t Chance::next() { return random_bits(seed, catom, tick, draws++); }

Scene make_scene(const Program& program, const std::map<world::Cell, std::uint64_t>& at, world::LatticeKind kind, std::int64_t tick,
                 std::size_t first_catoms, const std::set<std::pair<std::uint64_t, std::uint64_t>>& missing) {
    const world::Lattice& lattice = lattice_of(kind);
    Scene scene{.program = &program, .tick = tick, .first_catoms = static_cast<std::int64_t>(first_catoms), .links = {}, .world = {}};
    scene.world.resize(program.predicates.count());
    for (const auto& [cell, id] : at) {
        std::vector<Link>& links = scene.links[static_cast<std::int64_t>(id)];
        for (int port = 0; port < lattice.ports(); ++port)
            if (const auto other = at.find(lattice.neighbour(cell, port));
                other != at.end() && !missing.contains(std::minmax(id, other->second)))
                links.push_back({port, static_cast<std::int64_t>(other->second), lattice.opposite(port)});
        for (const PredicateId p : program.predicates.ids())
            for (Row& row : sensed(program.predicates[p].world, lattice, at, cell, static_cast<std::int64_t>(id), links, tick))
                scene.world[p.index()].insert(std::move(row));
    }
    return scene;
}

void set_tick(Scene& scene, std::int64_t tick) {
    scene.tick = tick;
    for (const PredicateId p : scene.program->predicates.ids()) {
        if (scene.program->predicates[p].world != WorldSource::Tick) continue;
        Rows& rows = scene.world[p.index()];
        rows.clear();
        for (const auto& [id, links] : scene.links) rows.insert({value_of(id), value_of(tick)});
    }
}

}  // namespace meld::reference
