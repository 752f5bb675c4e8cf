// Calls of Embree that pictures are made with.
#pragma once

#include "runtime/show/library/plugin/embree_table.h"

namespace meld::show {

// Only where need_view() has found the library.
const Embree& embree();

}  // namespace meld::show

namespace meld::render {

// They are called by their own names.
#define MELD_CALL(name) inline constexpr auto name = [](auto... with) { return show::embree().name(with...); };
#include "runtime/show/library/plugin/embree.def"
#undef MELD_CALL

}  // namespace meld::render
