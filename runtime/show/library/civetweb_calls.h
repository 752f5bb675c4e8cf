// Calls of civetweb that the viewer is served with.
#pragma once

#include "runtime/show/library/plugin/civetweb_table.h"

namespace meld::show {

// Only where need_view() has found the library.
const Civetweb& civetweb();

}  // namespace meld::show

namespace meld::view {

// They are called by their own names.
#define MELD_CALL(name) inline constexpr auto name = [](auto... with) { return show::civetweb().name(with...); };
#include "runtime/show/library/plugin/civetweb.def"
#undef MELD_CALL

}  // namespace meld::view
