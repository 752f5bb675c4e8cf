// A sequence of random numbers that a seed decides.
#pragma once

#include <cstdint>

#include "runtime/base/random.h"

namespace meld::graph {

class Draws {
  public:
    // `stream` keeps sequences of one seed apart.
    Draws(std::uint64_t seed, std::uint64_t stream) : seed_(seed), stream_(stream) {}
    std::uint64_t bits() { return random_bits(seed_, kGraphs, stream_, count_++); }
    // Below n, which is above 0 and at most 2^32: the high word of a product.
    std::uint64_t below(std::uint64_t n) { return (bits() >> 32) * n >> 32; }
    // In [0, 1).
    double unit() { return static_cast<double>(bits() >> 11) * 0x1p-53; }

  private:
    // Unlike any number of a catom, by which programs draw.
    static constexpr std::uint64_t kGraphs = ~std::uint64_t{0} - 1;
    std::uint64_t seed_, stream_, count_ = 0;
};

}  // namespace meld::graph
