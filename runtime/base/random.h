// Counter-based random numbers: the same key gives the same bits on any process, thread and machine.
#pragma once

#include <cstdint>
#include <span>

namespace meld {

// 64 random bits for a seed and three counters, by ten rounds of Philox (Salmon et al., "Parallel Random Numbers: As Easy
// as 1, 2, 3", SC 2011), from Random123. About 10 ns.
std::uint64_t random_bits(std::uint64_t seed, std::uint64_t a, std::uint64_t b, std::uint64_t c);

// The same for several counters b.
void random_bits(std::uint64_t seed, std::uint64_t a, std::span<const std::uint64_t> b, std::uint64_t c, std::span<std::uint64_t> out);

}  // namespace meld
