// Texts that modules are compiled with: the headers that emitted code includes.
#pragma once

#include <span>

#include "compiler/front/embedded.h"

namespace meld::driver {

using front::EmbeddedText;

// runtime/module/abi/extern.h, for functions in C and C++.
extern const char kExtern[];
// What modules are compiled with, by the path that they include: the ABI and the kernel.
extern const std::span<const EmbeddedText> kModuleHeaders;

}  // namespace meld::driver
