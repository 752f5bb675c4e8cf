// Texts that every program is read with: the prelude and the libraries in Meld.
#pragma once

#include <span>

namespace meld::front {

struct EmbeddedText {
    const char* name;
    const char* text;
};

extern const char kPrelude[];
// stdlib/*.meld without the prelude, for `use "name"`.
extern const std::span<const EmbeddedText> kLibraries;

}  // namespace meld::front
