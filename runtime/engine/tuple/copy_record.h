// Copies the record that a catom has in a column.
#pragma once

#include <cstddef>
#include <cstring>

namespace meld::tuple {

// A copy of a length known at compile time is a few instructions.
inline void copy_record(void* to, const void* from, std::size_t bytes) {
    switch (bytes) {
        case 4:
            std::memcpy(to, from, 4);
            break;
        case 8:
            std::memcpy(to, from, 8);
            break;
        case 16:
            std::memcpy(to, from, 16);
            break;
        case 24:
            std::memcpy(to, from, 24);
            break;
        default:
            std::memcpy(to, from, bytes);
    }
}

}  // namespace meld::tuple
