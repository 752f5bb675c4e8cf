// Regions of one catom.
#pragma once

#include <cstdint>
#include <optional>

#include "runtime/world/shapes/shape.h"

namespace meld::world {

// The id, if the region is written as that of one catom, `id == 4`, so that nobody has to look at all catoms.
std::optional<std::uint64_t> named_id(const Region& region);

}  // namespace meld::world
