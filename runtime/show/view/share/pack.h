// Bytes as a page carries them: compressed, in letters.
#pragma once

#include <string>
#include <string_view>

namespace meld::view {

// Compressed as zlib does, which browsers call deflate.
std::string deflated(std::string_view bytes);

std::string base64(std::string_view bytes);

}  // namespace meld::view
