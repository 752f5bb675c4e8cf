// `meldsim world`: what a world file describes.
#pragma once

#include <string>

namespace meld::driver {

int world_command(const std::string& path);

}  // namespace meld::driver
