// Any bytes as text, for JSON, which is UTF-8: programs, worlds and names of files need not be.
#pragma once

#include <string>

namespace meld {

// Each byte stands as the character of its number, so ASCII stays as it is.
std::string text_of_bytes(const std::string& bytes);
// The bytes of such a text.
std::string bytes_of_text(const std::string& text);

}  // namespace meld
