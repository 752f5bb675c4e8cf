// The functions of Embree that pictures are made with.
#pragma once

#include <embree3/rtcore.h>

namespace meld::show {

struct Embree {
#define MELD_CALL(name) decltype(&::name) name;
#include "runtime/show/library/plugin/embree.def"
#undef MELD_CALL
};

}  // namespace meld::show
