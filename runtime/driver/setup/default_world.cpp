#include "runtime/driver/setup/default_world.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <utility>

#include "runtime/comm/transport/communicator.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/module/abi/geometry_abi.h"
#include "runtime/module/abi/senses.h"
#include "runtime/sim/core/subdomain.h"
#include "runtime/world/ensemble/target.h"

namespace meld::driver {

namespace {

// A text that names a greater catom means something else.
constexpr std::uint64_t kMostNodes = 1'000'000;

// The first link of the text whose ends exist and do not touch, or do not exist; nothing if there is none.
Result<const LinkInfo*> first_apart(const ModuleInfo& module, const world::World& cube) {
    const Result<world::Target> target = world::Target::make(cube, world::Lattice(cube.lattice));
    if (!target) return tl::unexpected<Error>(target.error());
    ModuleInfo no_program{};
    no_program.abi_version = kAbiVersion;
    const auto alone = comm::make_single();
    sim::Subdomain subdomain(no_program, cube, *target, *alone, 1);
    if (const auto done = subdomain.populate(); !done) return tl::unexpected<Error>(done.error());
    for (u32 i = 0; i < module.link_count; ++i) {
        const LinkInfo& link = module.links[i];
        if (link.from == link.to) continue;
        const auto from = subdomain.ensemble.find(link.from), to = subdomain.ensemble.find(link.to);
        bool touch = false;
        if (from && to) each_link(subdomain.geometry(), *from, [&](i32, u32 other) { touch = touch || other == *to; });
        if (!touch) return &link;
    }
    return nullptr;
}

using Links = std::set<std::pair<std::uint64_t, std::uint64_t>>;
// The links of the text.
Links links_of(const ModuleInfo& module) {
    Links links;
    for (u32 i = 0; i < module.link_count; ++i) {
        const LinkInfo& link = module.links[i];
        if (link.from != link.to) links.insert(std::minmax(link.from, link.to));
    }
    return links;
}

// Whether some rule asks for the links of the world, or for its cells.
bool reads_links(const ModuleInfo& module) {
    for (const auto& [name, arity, source] : sense_names()) {
        const bool links = name == "neighbor" || name == "neighborCount" || info(source).has(SenseInfo::kCells);
        const std::optional<u32> p = links ? tuple::find_sensed(module, name, arity) : std::nullopt;
        if (p && module.predicates[*p].storage == Storage::World && module.predicates[*p].read) return true;
    }
    return false;
}

}  // namespace

Result<world::World> default_world() {
    return world::parse_world("lattice = \"cubic\"\n[[body]]\nshape = \"box(10, 10, 10)\"\n", "the default, a cube of 1,000 catoms");
}

Result<world::World> default_world(const ModuleInfo& module) {
    Result<world::World> cube = default_world();
    if (!cube) return cube;
    const Links links = links_of(module);
    const std::uint64_t nodes = std::max<std::uint64_t>(module.named_nodes, 1);
    const bool own_links = !links.empty() || (module.finds_ways && nodes > 1);
    const bool knows_nodes = module.makes_nodes || (own_links && !reads_links(module));
    if (module.link_count == 0 && !knows_nodes) return cube;
    const Result<const LinkInfo*> apart = first_apart(module, *cube);
    if (!apart) return tl::unexpected<Error>(apart.error());
    if ((*apart == nullptr && !knows_nodes) || nodes > kMostNodes) return cube;
    std::vector<std::string> listed;
    for (const auto& [from, to] : links) listed.push_back(fmt::format("[{}, {}]", from, to));
    Result<world::World> graph =
        world::parse_world(fmt::format("lattice = \"graph\"\nnodes = {}\nlinks = [\n    {}\n]\n", nodes, fmt::join(listed, ",\n    ")),
                           fmt::format("the default, the graph of the program's {} links", links.size()));
    if (!graph) return graph;
    // Nodes of such programs send to any that they know.
    graph->network.reach = world::Reach::Any;
    if (*apart != nullptr)
        graph->warnings.push_back(fmt::format(
            "{}:{}: @{} and @{} do not touch in the default world, so this run takes place in the graph of the links that the program "
            "lists; --world chooses another one",
            (*apart)->file, (*apart)->line, (*apart)->from, (*apart)->to));
    else
        graph->warnings.push_back(
            fmt::format("{}: its rules {}, so this run takes place in the graph of {} and the links that the program lists; --world "
                        "chooses another one",
                        module.sources[0].path,
                        module.makes_nodes  ? "make nodes"
                        : module.finds_ways ? "send facts to nodes that no link leads to"
                                            : "read only links that the program lists",
                        nodes == 1 ? "@0" : fmt::format("@0 to @{}", nodes - 1)));
    return graph;
}

}  // namespace meld::driver
