// The functions of civetweb that the viewer is served with.
#pragma once

#include <civetweb.h>

namespace meld::show {

struct Civetweb {
#define MELD_CALL(name) decltype(&::name) name;
#include "runtime/show/library/plugin/civetweb.def"
#undef MELD_CALL
};

}  // namespace meld::show
