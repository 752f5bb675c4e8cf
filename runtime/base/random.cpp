#include "runtime/base/random.h"

#include <Random123/philox.h>

namespace meld {

std::uint64_t random_bits(std::uint64_t seed, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
    // There are few draws in a tick: their number shares a word with the tick.
    const r123::Philox2x64::ctr_type counter{{a, b ^ (c << 40)}};
    return r123::Philox2x64()(counter, r123::Philox2x64::key_type{{seed}})[0];
}

}  // namespace meld
