#include "tests/reference/trials/scene.h"

#include <memory>

#include "runtime/base/random.h"
#include "tests/reference/trials/worlds.h"

namespace meld::reference {

using check::WorldSource;

namespace {

// Its tables take longer to make than all the rest of a scene.
const world::Lattice& lattice_of(world::LatticeKind kind) {
    static std::map<world::LatticeKind, world::Lattice> made;
    return made.try_emplace(kind, kind).first->second;
}

// Of one catom.
struct Place {
    const retraction::Case& world;
    const retraction::Mirror& mirror;
    const graph::Graph* graph;  // If it is one.
    world::Cell cell;
    std::int64_t id;

    world::Vec3 position() const {
        if (graph == nullptr) return lattice_of(world.lattice).position(cell);
        const auto number = static_cast<std::uint64_t>(id);
        const auto born = mirror.made.find(number);
        const graph::Point& at = born == mirror.made.end() ? graph->places[*graph->find(number)] : born->second;
        return {at[0], at[1], at[2]};
    }
};

// The facts of one catom; the target is empty in every case.
std::vector<Row> sensed(WorldSource source, const Place& place, const std::vector<Link>& links, std::int64_t tick) {
    const Value me = value_of(place.id);
    switch (source) {
        case WorldSource::NeighborCount:
            return {{me, value_of(static_cast<std::int64_t>(links.size()))}};
        case WorldSource::Vacant: {
            std::vector<Row> rows;
            const world::Lattice& lattice = lattice_of(place.world.lattice);
            for (int port = 0; port < lattice.ports(); ++port)
                if (!place.mirror.at.contains(lattice.neighbour(place.cell, port))) rows.push_back({me, value_of(std::int64_t{port})});
            return rows;
        }
        case WorldSource::Cell:
            return {{me, value_of(std::int64_t{place.cell.x}), value_of(std::int64_t{place.cell.y}), value_of(std::int64_t{place.cell.z})}};
        case WorldSource::Position:
        case WorldSource::PositionVector: {
            const world::Vec3 at = place.position();
            if (source == WorldSource::PositionVector) return {{me, value_of(Values{value_of(at[0]), value_of(at[1]), value_of(at[2])})}};
            return {{me, value_of(at[0]), value_of(at[1]), value_of(at[2])}};
        }
        case WorldSource::Id:
            return {{me, me}};
        case WorldSource::Tick:
            return {{me, value_of(tick)}};
        default:
            return {};
    }
}

}  // namespace

std::uint64_t Chance::next() { return random_bits(seed, catom, tick, draws++); }

namespace {

std::vector<Link> links_of(const retraction::Case& world, const retraction::Mirror& mirror, world::Cell cell, std::uint64_t id) {
    std::vector<Link> links;
    if (world.graph) {
        const auto mine = mirror.ports.find(id);
        if (mine == mirror.ports.end()) return links;
        for (const auto& [port, other] : mine->second)
            for (const auto& [back, me] : mirror.ports.at(other))
                if (me == id) links.push_back({port, static_cast<std::int64_t>(other), back});
        return links;
    }
    const world::Lattice& lattice = lattice_of(world.lattice);
    for (int port = 0; port < lattice.ports(); ++port)
        if (const auto other = mirror.at.find(lattice.neighbour(cell, port));
            other != mirror.at.end() && !mirror.missing.contains(std::minmax(id, other->second)))
            links.push_back({port, static_cast<std::int64_t>(other->second), lattice.opposite(port)});
    return links;
}

}  // namespace

Scene make_scene(const Program& program, const retraction::Case& world, const retraction::Mirror& mirror, std::int64_t tick) {
    Scene scene{.program = &program, .tick = tick, .first_catoms = static_cast<std::int64_t>(world.cells.size()), .links = {}, .world = {}};
    scene.world.resize(program.predicates.count());
    const std::shared_ptr<const graph::Graph> graph = world.graph ? make_graph(world) : nullptr;
    for (const auto& [cell, id] : mirror.at) {
        std::vector<Link>& links = scene.links[static_cast<std::int64_t>(id)];
        links = links_of(world, mirror, cell, id);
        for (const PredicateId p : program.predicates.ids())
            for (Row& row :
                 sensed(program.predicates[p].world, {world, mirror, graph.get(), cell, static_cast<std::int64_t>(id)}, links, tick))
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
