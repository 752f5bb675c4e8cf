// Calls of Cairo that pictures are written over with.
#pragma once

#include "runtime/show/library/plugin/cairo_table.h"

namespace meld::show {

// Only where need_view() has found the library.
const Cairo& cairo();

}  // namespace meld::show

namespace meld::render {

// They are called by their own names.
#define MELD_CALL(name) inline constexpr auto name = [](auto... with) { return show::cairo().name(with...); };
#include "runtime/show/library/plugin/cairo.def"
#undef MELD_CALL

}  // namespace meld::render
