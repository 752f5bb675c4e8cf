// Text that a terminal shows and does not obey. Programs, worlds, recordings and the names of files are data: what they say may
// reach a terminal in messages and in what catoms print, and must neither move its cursor nor turn the reading order around.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace meld {

// The length in bytes of the character of UTF-8 that the text begins with; 0 if it begins with none, or with one that is not
// seen but has an effect: a control character (C0, DEL, C1) or a change of reading direction (U+202A to 202E, U+2066 to 2069).
std::size_t visible_character(std::string_view text);

// The text with every byte of what is no such character as \x and two digits; line breaks and tabs stay. What it returns it
// leaves as it is.
std::string visible(std::string_view text);

}  // namespace meld
