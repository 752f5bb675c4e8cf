// A world file (TOML): lattice, bodies, target, facts, motion, network, record, limits. It is read and checked as a whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/world/description/world.h"

namespace meld::world {

// Reads and checks a world file. Errors name file, line, column, and the nearest key or shape.
Result<World> read_world(const std::string& path);
// Whether a file says which catoms there are, or has mistakes, or is a pipe. One that does not can be read after keys that do.
bool says_places(const std::string& path);
Result<std::string> read_text(const std::string& path);
// Where a key can be added to a table at the top of a text without mistakes, behind its header or its brace, or else with `before` and
// `after` around it.
struct KeyPlace {
    std::size_t at;
    std::string before, after;
};
KeyPlace key_place(const std::string& text, const std::string& table);
// The same from text; `path` is only for messages, and for finding what it names, unless `files` has all of that.
Result<World> parse_world(const std::string& text, const std::string& path, const WorldFiles* files = nullptr);

// Gives the world another seed; a graph that is generated is made again. Errors: the generator finds none.
Result<void> set_seed(World& world, std::uint64_t seed);
// Gives the ports of the world the numbers of this robot, or "lattice" for their own. Errors: there is no such robot; its modules stand on
// another lattice; a graph and bodies have no sides.
Result<void> set_ports(World& world, std::string_view name);

// The lattice of a file, and whose numbers its ports have: the defaults if it has mistakes, or is a pipe.
struct PortKeys {
    std::string lattice;
    std::string ports;  // "": the file does not say.
};
PortKeys port_keys(const std::string& path);

// World::by_links of a file; false if that has mistakes, or is a pipe, which can be read only once. Cost: its text is parsed, but no file
// that it names is read.
bool asks_for_links(const std::string& path);
// The same of World::is_graph().
bool asks_for_graph(const std::string& path);
// Whether it says acyclic = true: that links of its graph lead in no circle.
bool says_acyclic(const std::string& path);

// World::programs of a file, in the same way: none if it has mistakes, or is a pipe.
std::vector<std::string> programs_named(const std::string& path);

}  // namespace meld::world
