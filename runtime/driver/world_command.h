// `meldsim world`: what a world file describes.
#pragma once

#include <string>
#include <vector>

namespace meld::driver {

// Prints the size of the world and its target, and reports every reason why a run could not start that can be found without a program.
// `extensions` are shared objects that the world may choose from. Returns the exit code.
int world_command(const std::string& path, const std::vector<std::string>& extensions);

}  // namespace meld::driver
