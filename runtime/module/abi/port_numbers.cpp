// The tables. A robot's row gives for each of its numbers the port of our lattice that leads the same way.
#include "runtime/module/abi/port_numbers.h"

#include <fmt/format.h>

namespace meld {
namespace {

constexpr std::array<PortNumbers, 4> kLattices = {{
    {kLatticePorts, "square", "", 4, {{{0, "east right"}, {1, "north top up back"}, {2, "west left"}, {3, "south bottom down front"}}}},
    {kLatticePorts,
     "hex",
     "",
     6,
     {{{0, "east right"},
       {1, "north-east top-right up-right"},
       {2, "north-west top-left up-left"},
       {3, "west left"},
       {4, "south-west bottom-left down-left"},
       {5, "south-east bottom-right down-right"}}}},
    {kLatticePorts,
     "cubic",
     "",
     6,
     {{{0, "east right"}, {1, "west left"}, {2, "north back"}, {3, "south front"}, {4, "top up"}, {5, "bottom down"}}}},
    {kLatticePorts,
     "fcc",
     "",
     12,
     {{{0, "east right side"},
       {1, "north back side"},
       {2, "west left side"},
       {3, "south front side"},
       {4, "top-north-east up"},
       {5, "top-north-west up"},
       {6, "top-south-west up"},
       {7, "top-south-east up"},
       {8, "bottom-north-east down"},
       {9, "bottom-north-west down"},
       {10, "bottom-south-west down"},
       {11, "bottom-south-east down"}}}},
}};

constexpr std::array<PortNumbers, 5> kRobots = {{
    {"blinky", "cubic", "Blinky Blocks", 6, {{{5, "bottom down"}, {2, "north"}, {0, "east"}, {1, "west"}, {3, "south"}, {4, "top up"}}}},
    {"blinky-visiblesim",
     "cubic",
     "Blinky Blocks and Robot Blocks in VisibleSim",
     6,
     {{{5, "bottom down"}, {2, "back"}, {0, "right"}, {3, "front"}, {1, "left"}, {4, "top up"}}}},
    {"smartblocks", "square", "SmartBlocks", 4, {{{1, "north"}, {0, "east"}, {3, "south"}, {2, "west"}}}},
    {"catoms2d",
     "hex",
     "Catoms2D",
     6,
     {{{0, "right"}, {1, "top-right"}, {2, "top-left"}, {3, "left"}, {4, "bottom-left"}, {5, "bottom-right"}}}},
    {"catoms3d",
     "fcc",
     "Catoms3D",
     12,
     {{{0, "side east"},
       {1, "side north"},
       {4, "top-north-east"},
       {5, "top-north-west"},
       {6, "top-south-west"},
       {7, "top-south-east"},
       {2, "side west"},
       {3, "side south"},
       {10, "bottom-south-west"},
       {11, "bottom-south-east"},
       {8, "bottom-north-east"},
       {9, "bottom-north-west"}}}},
}};

}  // namespace

std::string PortNumbers::table() const {
    std::string text;
    for (int number = 0; number < count; ++number) {
        const std::string_view words = sides[static_cast<std::size_t>(number)].words;
        text += fmt::format("{}{} {}", number == 0 ? "" : ", ", number, words.substr(0, words.find(' ')));
    }
    return text;
}

std::span<const PortNumbers> lattice_port_numbers() { return kLattices; }

std::span<const PortNumbers> robot_port_numbers() { return kRobots; }

const PortNumbers* port_numbers_of(std::string_view name) {
    for (const PortNumbers& row : kRobots)
        if (row.name == name) return &row;
    return nullptr;
}

std::vector<std::string_view> port_numbers_names() {
    std::vector<std::string_view> names{kLatticePorts};
    for (const PortNumbers& row : kRobots) names.push_back(row.name);
    return names;
}

}  // namespace meld
