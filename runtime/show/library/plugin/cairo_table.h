// The functions of Cairo that pictures are written over with.
#pragma once

#include <cairo/cairo-svg.h>
#include <cairo/cairo.h>

namespace meld::show {

struct Cairo {
#define MELD_CALL(name) decltype(&::name) name;
#include "runtime/show/library/plugin/cairo.def"
#undef MELD_CALL
};

}  // namespace meld::show
