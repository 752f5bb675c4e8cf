#include "runtime/driver/setup/default_world.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "runtime/comm/transport/communicator.h"
#include "runtime/module/abi/geometry_abi.h"
#include "runtime/sim/core/subdomain.h"
#include "runtime/world/ensemble/target.h"
#include "runtime/world/file/world_file.h"

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

// "@0 to @4, @7", or how many there are.
std::string in_words(const std::vector<std::uint64_t>& nodes) {
    constexpr std::size_t kMaxRanges = 4;
    std::vector<std::string> ranges;
    for (std::size_t i = 0; i < nodes.size();) {
        std::size_t last = i;
        while (last + 1 < nodes.size() && nodes[last + 1] == nodes[last] + 1) ++last;
        if (last == i + 1) last = i;  // Two are named one by one.
        ranges.push_back(last == i ? fmt::format("@{}", nodes[i]) : fmt::format("@{} to @{}", nodes[i], nodes[last]));
        i = last + 1;
    }
    if (ranges.size() > kMaxRanges) return fmt::format("the {} nodes that it names", nodes.size());
    return fmt::format("{}", fmt::join(ranges, ", "));
}

}  // namespace

Places default_places() {
    return {.text = "lattice = \"cubic\"\nbody = [{ shape = \"box(10, 10, 10)\" }]\n", .path = "the default, a cube of 1,000 catoms"};
}

Result<Places> default_places(const ModuleInfo& module) {
    Places cube = default_places();
    const Links links = links_of(module);
    std::vector<std::uint64_t> nodes(module.named_nodes, module.named_nodes + module.named_count);
    if (nodes.empty()) nodes.push_back(0);
    if (module.link_count == 0 && !module.own_graph) return cube;
    const Result<world::World> populated = default_world();
    if (!populated) return tl::unexpected<Error>(populated.error());
    const Result<const LinkInfo*> apart = first_apart(module, *populated);
    if (!apart) return tl::unexpected<Error>(apart.error());
    if ((*apart == nullptr && !module.own_graph) || nodes.back() >= kMostNodes) return cube;
    std::vector<std::string> listed;
    for (const auto& [from, to] : links) listed.push_back(fmt::format("[{}, {}]", from, to));
    Places graph{.text = fmt::format("lattice = \"graph\"\nnodes = [{}]\nlinks = [\n    {}\n]\n", fmt::join(nodes, ", "),
                                     fmt::join(listed, ",\n    ")),
                 .path = fmt::format("the default, the graph of the program's {} links", links.size()),
                 .graph = true};
    if (*apart != nullptr)
        graph.warnings.push_back(fmt::format(
            "{}:{}: @{} and @{} do not touch in the default world, so this run takes place in the graph of the links that the program "
            "lists; --world chooses another one",
            (*apart)->file, (*apart)->line, (*apart)->from, (*apart)->to));
    else
        graph.warnings.push_back(
            fmt::format("{}: its rules {}, so this run takes place in the graph of {} and the links that the program lists; --world "
                        "chooses another one",
                        module.sources[0].path,
                        module.makes_nodes  ? "make nodes"
                        : module.finds_ways ? "send facts to nodes that no link leads to"
                                            : "read only links that the program lists",
                        in_words(nodes)));
    return graph;
}

namespace {

Result<world::World> world_at(const Places& places) {
    Result<world::World> world =
        world::parse_world(places.text + (places.graph ? fmt::format("[network]\n{}\n", kReachesAny) : ""), places.path);
    if (world) world->warnings.insert(world->warnings.end(), places.warnings.begin(), places.warnings.end());
    return world;
}

}  // namespace

Result<world::World> default_world() { return world_at(default_places()); }

Result<world::World> default_world(const ModuleInfo& module) {
    const Result<Places> places = default_places(module);
    if (!places) return tl::unexpected<Error>(places.error());
    return world_at(*places);
}

}  // namespace meld::driver
