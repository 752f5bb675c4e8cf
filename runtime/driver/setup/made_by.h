// What a run was made by, for those who ask years later.
#pragma once

#include <nlohmann/json.hpp>

namespace meld::driver {

// The versions of Claymeld, of the interface of modules, of the compiler that makes modules and of the MPI library, and the processor that
// modules are made for; by name.
nlohmann::ordered_json made_by();

}  // namespace meld::driver
