// Errors of what catoms measure: the same for a seed on any number of processes and threads.
#pragma once

#include <array>
#include <cstdint>

namespace meld::sim {

// Whose error it is; unlike any number of a catom, by which programs draw.
enum class NoiseStream : std::uint64_t {
    Distances = ~std::uint64_t{0} - 8,
    Bearings = ~std::uint64_t{0} - 9,
    Gyros = ~std::uint64_t{0} - 10,
    Accelerometers = ~std::uint64_t{0} - 11,
    RangeFinders = ~std::uint64_t{0} - 12,
    LightSensors = ~std::uint64_t{0} - 13,
};

// Two numbers with the standard normal distribution (Box and Muller), by the seed, who measures, and what it measures or when. `what`
// should be a hash: what + 1 is used too.
std::array<double, 2> errors(std::uint64_t seed, NoiseStream stream, std::uint64_t who, std::uint64_t what);

}  // namespace meld::sim
