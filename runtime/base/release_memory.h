// Frees the memory of a vector. Assigning {} or clear() empties it but keeps the memory.
#pragma once

#include <vector>

namespace meld {

template <class T, class Allocator>
void release_memory(std::vector<T, Allocator>& array) {
    std::vector<T, Allocator>().swap(array);
}

}  // namespace meld
