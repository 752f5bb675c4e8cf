// The known word that a mistyped one was probably meant to be.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace meld {

// The known word that is reached from `word` with the fewest insertions, deletions, replacements and swaps of neighbouring letters
// (restricted Damerau-Levenshtein distance; a changed case costs nothing), if that is at most about a third of its letters, but at least
// one; of equals the alphabetically first. Never the word itself.
std::optional<std::string_view> nearest_name(std::string_view word, std::span<const std::string_view> known);

// "did you mean 'sphere'?" or, if nothing is near, "one of box, sphere, torus" (all known words in the given order).
std::string did_you_mean(std::string_view word, std::span<const std::string_view> known);

}  // namespace meld
