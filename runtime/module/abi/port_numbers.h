// How the sides of modules are numbered: on our lattices, and by other robots, whose programs name sides by the numbers of their own.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/module/abi/geometry_abi.h"

namespace meld {

// One side of a module. `words` are what programs call it, each without blanks, "top-right" where two words say it together.
struct Side {
    int port = 0;  // On our lattice.
    std::string_view words;
};

// The numbers of one robot's sides: the side with number i is sides[i].
struct PortNumbers {
    std::string_view name;     // As worlds write it: ports = "blinky". Of a lattice's own numbers: "lattice".
    std::string_view lattice;  // As worlds write it: lattice = "cubic".
    std::string_view robot;
    int count = 0;
    std::array<Side, kMaxPorts> sides{};

    std::span<const Side> all() const { return {sides.data(), static_cast<std::size_t>(count)}; }
    // "0 bottom, 1 north, 2 east, ...": the first word of each.
    std::string table() const;
};

// The name of a lattice's own numbers, which are the default.
inline constexpr std::string_view kLatticePorts = "lattice";

// Our lattices.
std::span<const PortNumbers> lattice_port_numbers();
// Other robots.
std::span<const PortNumbers> robot_port_numbers();
// Those of a robot, or nullptr.
const PortNumbers* port_numbers_of(std::string_view name);
// All that may stand after `ports =`, the lattice's own first.
std::vector<std::string_view> port_numbers_names();

}  // namespace meld
