#include "runtime/show/view/share/pack.h"

#include <zlib.h>

#include <array>
#include <cstdint>

#include "runtime/base/assert.h"

namespace meld::view {

std::string deflated(std::string_view bytes) {
    uLongf size = compressBound(static_cast<uLong>(bytes.size()));
    std::string out(size, '\0');
    const int done = compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                               static_cast<uLong>(bytes.size()), Z_DEFAULT_COMPRESSION);
    MELD_CHECK(done == Z_OK);
    out.resize(size);
    return out;
}

std::string base64(std::string_view bytes) {
    constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    out.reserve((bytes.size() + 2) / 3 * 4);
    const auto byte = [&](std::size_t i) { return i < bytes.size() ? std::uint32_t{static_cast<unsigned char>(bytes[i])} : 0U; };
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::uint32_t three = byte(i) << 16 | byte(i + 1) << 8 | byte(i + 2);
        const std::array<char, 4> four = {kLetters[three >> 18], kLetters[three >> 12 & 63],
                                          i + 1 < bytes.size() ? kLetters[three >> 6 & 63] : '=',
                                          i + 2 < bytes.size() ? kLetters[three & 63] : '='};
        out.append(four.data(), four.size());
    }
    return out;
}

}  // namespace meld::view
