// The order in which people look for things: numbers within texts as numbers, so @3 comes before @168.
#pragma once

#include <string_view>

namespace meld {

// Whether a comes before b. Runs of digits compare as whole numbers of any length, and a minus sign in front of one that follows no word
// makes it negative; all else compares by bytes. Texts that are equal so compare by bytes, so that it is a total order.
bool natural_less(std::string_view a, std::string_view b);

}  // namespace meld
