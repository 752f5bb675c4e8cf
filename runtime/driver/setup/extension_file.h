// Loads extensions: shared objects that users write in C++, which add implementations to the registry.
#pragma once

#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/sim/core/extension.h"

namespace meld::driver {

// Opens each file and lets it add to the registry. The files stay open until the process ends. Errors: a file cannot be opened,
// is not an extension, or was built for another version of Claymeld.
Result<void> add_extensions(const std::vector<std::string>& files, sim::Registry& registry);

}  // namespace meld::driver
