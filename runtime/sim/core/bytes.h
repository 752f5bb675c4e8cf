// Plain values into and out of packets between parts of one run. All parts run the same program on the same kind of
// machine, so there is no conversion.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace meld::sim {

template <class T>
void put(std::vector<std::byte>& out, const T& value) {
    const auto* bytes = reinterpret_cast<const std::byte*>(&value);
    out.insert(out.end(), bytes, bytes + sizeof(T));
}

template <class T>
T take_value(const std::byte*& from) {
    T value;
    std::memcpy(&value, from, sizeof(T));
    from += sizeof(T);
    return value;
}

inline void put_text(std::vector<std::byte>& out, std::string_view text) {
    put(out, static_cast<std::uint32_t>(text.size()));
    const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
    out.insert(out.end(), bytes, bytes + text.size());
}

inline std::string take_text(const std::byte*& from) {
    const auto size = take_value<std::uint32_t>(from);
    std::string text(reinterpret_cast<const char*>(from), size);
    from += size;
    return text;
}

}  // namespace meld::sim
