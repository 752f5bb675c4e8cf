// Plain values into and out of packets between parts of one run. All parts run the same program on the same kind of
// machine, so there is no conversion.
#pragma once

#include <cstddef>
#include <cstring>
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

}  // namespace meld::sim
