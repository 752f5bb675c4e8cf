#include "runtime/sim/core/sensor_noise.h"

#include <cmath>
#include <numbers>

#include "runtime/base/random.h"

namespace meld::sim {

std::array<double, 2> errors(std::uint64_t seed, NoiseStream stream, std::uint64_t who, std::uint64_t what) {
    const auto unit = [&](std::uint64_t which) {
        return (static_cast<double>(random_bits(seed, static_cast<std::uint64_t>(stream), who, what + which) >> 11) + 0.5) * 0x1p-53;
    };
    const double radius = std::sqrt(-2 * std::log(unit(0))), turn = 2 * std::numbers::pi * unit(1);
    return {radius * std::cos(turn), radius * std::sin(turn)};
}

}  // namespace meld::sim
