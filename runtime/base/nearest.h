// The known word a mistyped one was probably meant to be.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace meld {

// The known word that takes the fewest insertions, deletions, replacements and swaps of neighbouring letters to reach from
// `word` (restricted Damerau-Levenshtein distance; a changed case costs nothing), if that is about a third of its letters at
// most, at least one; the first in the alphabet of equals. Never the word itself.
std::optional<std::string_view> nearest_name(std::string_view word, std::span<const std::string_view> known);

// "did you mean 'sphere'?" or, with nothing near, "one of box, sphere, torus" (all known words in the order given).
std::string did_you_mean(std::string_view word, std::span<const std::string_view> known);

}  // namespace meld
