#include "runtime/world/file/amoebot_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>

namespace meld::world {

bool says_amoebots(const toml::table& top) { return top["motion"]["kind"].value<std::string_view>() == "amoebot"; }

void read_amoebots(TomlReader& reader, const toml::table& table, MotionOptions& motion) {
    const Section section(reader, table, "[motion]", {"kind", "activation", "compass", "chirality", "keep_connected"});
    motion.kind = "amoebot";
    std::string activation = "all", compass = "common", chirality = "common";
    section.read_choice("activation", activation, {"all", "one", "random", "fair"});
    section.read_choice("compass", compass, {"common", "own"});
    section.read_choice("chirality", chirality, {"common", "own"});
    using Activation = AmoebotOptions::Activation;
    motion.amoebots = {.activation = activation == "one"      ? Activation::One
                                     : activation == "random" ? Activation::Random
                                     : activation == "fair"   ? Activation::Fair
                                                              : Activation::All,
                       .own_compass = compass == "own",
                       .own_chirality = chirality == "own"};
    section.read("keep_connected", motion.keep_connected);
}

void check_amoebots(TomlReader& reader, const Section& top, const World& world) {
    const toml::source_region& motion = top.find("motion")->source();
    if (world.is_graph() || world.lattice != LatticeKind::Hex)
        return reader.wrong(motion, fmt::format("amoebots live on the triangular lattice, and this world is {}", world.lattice_name()),
                            "write lattice = \"hex\"");
    if (world.ports != nullptr)
        reader.wrong(top.find("ports")->source(), "amoebots number their ports by compasses of their own", "take ports out");
    if (top.has("held")) reader.wrong(top.find("held")->source(), "amoebots hold no units", "take held out");
    const bool delays = world.apart() || world.network.detect > 0;
    for (const char* section : {"network", "clock"})
        if (delays && top.has(section))
            reader.wrong(top.find(section)->source(),
                         fmt::format("[{}] delays what a catom reads, and amoebots read their neighbours as they are", section),
                         "take it out; [motion] activation says which amoebots act in a tick");
    const auto links = [](const auto& failures) { return failures.strikes_links(); };
    if (std::ranges::any_of(world.events, links) || std::ranges::any_of(world.faults, links))
        reader.wrong(motion, "amoebots that touch always have a link, and an event or fault cuts or makes links", "take it out");
}

}  // namespace meld::world
