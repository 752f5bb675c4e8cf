#include "runtime/base/random.h"

#include <Random123/philox.h>

namespace meld {

[[gnu::always_inline]] static inline std::uint64_t bits_of(std::uint64_t seed, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
    // There are few draws in a tick: their number shares a word with the tick.
    const r123::Philox2x64::ctr_type counter{{a, b ^ (c << 40)}};
    return r123::Philox2x64()(counter, r123::Philox2x64::key_type{{seed}})[0];
}

std::uint64_t random_bits(std::uint64_t seed, std::uint64_t a, std::uint64_t b, std::uint64_t c) { return bits_of(seed, a, b, c); }

// In one loop, so that the processor works on several at a time: the rounds of one wait for each other.
void random_bits(std::uint64_t seed, std::uint64_t a, std::span<const std::uint64_t> b, std::uint64_t c, std::span<std::uint64_t> out) {
    for (std::size_t i = 0; i < b.size(); ++i) out[i] = bits_of(seed, a, b[i], c);
}

}  // namespace meld
