// Text that a terminal shows but does not interpret. Programs, worlds, recordings and file names are data: their text may reach a terminal
// in messages and in what catoms print, and must neither move its cursor nor reverse the reading direction.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace meld {

// The length in bytes of the UTF-8 character at the start of the text; 0 if there is none, or one that is invisible but has an effect: a
// control character (C0, DEL, C1) or a change of reading direction (U+202A to 202E, U+2066 to 2069).
std::size_t visible_character(std::string_view text);

// The text with every other byte replaced by \x and two digits; line breaks and tabs stay. Applying it again changes nothing.
std::string visible(std::string_view text);

}  // namespace meld
