// Hooks the changes by words into libFuzzer: two in three are ours, one is its own.
#include <cstdint>
#include <cstring>
#include <string>

#include "tests/fuzz/mutate.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

std::string_view text(const std::uint8_t* data, std::size_t size) { return {reinterpret_cast<const char*>(data), size}; }

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned seed) {
    if (seed % 3 == 0) return LLVMFuzzerMutate(data, size, max_size);
    const std::string changed = meld::fuzz::mutate(text(data, size), {}, seed, max_size);
    std::memcpy(data, changed.data(), changed.size());
    return changed.size();
}

extern "C" std::size_t LLVMFuzzerCustomCrossOver(const std::uint8_t* a, std::size_t a_size, const std::uint8_t* b, std::size_t b_size,
                                                 std::uint8_t* out, std::size_t max_size, unsigned seed) {
    const std::string changed = meld::fuzz::mutate(text(a, a_size), text(b, b_size), seed, max_size);
    std::memcpy(out, changed.data(), changed.size());
    return changed.size();
}
