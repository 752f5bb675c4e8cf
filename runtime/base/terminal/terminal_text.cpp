#include "runtime/base/terminal/terminal_text.h"

#include <fmt/format.h>

#include <algorithm>

namespace meld {

namespace {

// Whether this character of three bytes changes the reading direction.
bool turns_direction(unsigned first, unsigned second, unsigned third) {
    if (first != 0xe2) return false;
    return (second == 0x80 && third >= 0xaa && third <= 0xae) || (second == 0x81 && third >= 0xa6 && third <= 0xa9);
}

}  // namespace

std::size_t visible_character(std::string_view text) {
    const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
    const auto follows = [&](std::size_t i) { return (byte(i) & 0xc0u) == 0x80u; };
    if (byte(0) < 0x20 || byte(0) == 0x7f) return 0;
    if (byte(0) < 0x80) return 1;
    if (byte(0) >= 0xc2 && byte(0) < 0xe0) return follows(1) && (byte(0) > 0xc2 || byte(1) >= 0xa0) ? 2 : 0;
    if (byte(0) >= 0xe0 && byte(0) < 0xf0) {
        const bool surrogate = byte(0) == 0xed && byte(1) >= 0xa0, overlong = byte(0) == 0xe0 && byte(1) < 0xa0;
        return follows(1) && follows(2) && !surrogate && !overlong && !turns_direction(byte(0), byte(1), byte(2)) ? 3 : 0;
    }
    const bool overlong = byte(0) == 0xf0 && byte(1) < 0x90, beyond = byte(0) > 0xf4 || (byte(0) == 0xf4 && byte(1) >= 0x90);
    return byte(0) >= 0xf0 && follows(1) && follows(2) && follows(3) && !overlong && !beyond ? 4 : 0;
}

std::string visible(std::string_view text) {
    std::string shown;
    shown.reserve(text.size());
    while (!text.empty()) {
        const char c = text.front();
        const std::size_t size = c == '\n' || c == '\t' ? 1 : visible_character(text);
        if (size == 0)
            shown += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
        else
            shown += text.substr(0, size);
        text.remove_prefix(std::max<std::size_t>(1, size));
    }
    return shown;
}

}  // namespace meld
