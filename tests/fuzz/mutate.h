// Changes Meld text by its words rather than its bytes, so that a fair share of what comes out is read to the end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace meld::fuzz {

// The words of a text with what separates them: names, numbers, strings, signs, blanks. Together they are the text.
std::vector<std::string_view> words(std::string_view text);
// The items of a text: up to and with each full stop at the end of a line. Lines, if no line ends with one.
std::vector<std::string_view> items(std::string_view text);

// One change drawn from the seed: an item dropped, doubled, moved or taken from `other`; a word replaced by another of the
// same sort, doubled, dropped or swapped with its neighbour; a number by an awkward one. At most `limit` bytes.
std::string mutate(std::string_view text, std::string_view other, std::uint32_t seed, std::size_t limit);

}  // namespace meld::fuzz
