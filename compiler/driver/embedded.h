// Texts that are part of meldc: the prelude, the libraries in Meld, and the headers that emitted code includes.
#pragma once

#include <span>

namespace meld::driver {

struct EmbeddedText {
    const char* name;
    const char* text;
};

extern const char kPrelude[];
// runtime/abi/extern.h, for functions in C and C++.
extern const char kExtern[];
// stdlib/*.meld without the prelude, for `use "name"`.
extern const std::span<const EmbeddedText> kLibraries;
// What modules are compiled with, by the path that they include: the ABI and the kernel.
extern const std::span<const EmbeddedText> kModuleHeaders;

}  // namespace meld::driver
