// In a program that is built without pictures and the viewer.
#pragma once

#include "runtime/base/assert.h"

namespace meld::show {

// Where what was left out would be called. Nobody comes there: need_view() has said so before.
[[noreturn]] inline void left_out(const char* what) {
    assertion_failed("check", what, __FILE__, __LINE__, "it is called without need_view()");
}

}  // namespace meld::show
