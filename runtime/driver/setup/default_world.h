// The world of a program that is given none.
#pragma once

#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/module/abi/module_abi.h"
#include "runtime/world/description/world.h"

namespace meld::driver {

// Where catoms are in such a world, as the keys at the top of a world file, to which other keys can be added.
struct Places {
    std::string text;
    std::string path;  // In messages.
    bool graph = false;
    std::vector<std::string> warnings = {};
};
// A key of [network] in the graph of a program's links: nodes of such programs send to any that they know.
constexpr const char* kReachesAny = "reach = \"any\"";

// A cube of 1,000 catoms. If the program's text links catoms that do not touch there, edge(@0, @5), or if its rules need no cells and no
// links but those of the text, or make nodes, it is the graph of these links instead, with the nodes that the text names and
// no others, and a warning that says so. Cost: the cube is populated, if there are links.
Result<Places> default_places(const ModuleInfo& module);
Result<world::World> default_world(const ModuleInfo& module);
// Without a program: the cube.
Places default_places();
Result<world::World> default_world();

}  // namespace meld::driver
