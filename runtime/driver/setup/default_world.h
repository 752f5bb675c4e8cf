// The world of a program that is given none.
#pragma once

#include <string>

#include "runtime/base/error.h"
#include "runtime/module/abi/module_abi.h"
#include "runtime/world/file/world_file.h"

namespace meld::driver {

// A cube of 1,000 catoms. If the program's text links catoms that do not touch there, edge(@0, @5), or if its rules need no cells and no
// links but those of the text, or make nodes, it is the graph of these links instead, with the nodes that the text names and
// no others, and a warning that says so. Cost: the cube is populated, if there are links.
Result<world::World> default_world(const ModuleInfo& module);
// Without a program: the cube.
Result<world::World> default_world();

}  // namespace meld::driver
