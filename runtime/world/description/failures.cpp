#include "runtime/world/description/failures.h"

#include <fmt/format.h>

#include <algorithm>

#include "runtime/base/random.h"

namespace meld::world {
namespace {

// So that they differ from those of links and clocks.
constexpr std::uint64_t kFaultSalt = 0x6661756c74;

bool drawn(double probability, std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1p-53 < probability; }

// Ids are far below 2^48, and nobody writes so many tables.
std::uint64_t use(Fault fault, std::size_t number) {
    return (static_cast<std::uint64_t>(fault) | static_cast<std::uint64_t>(number) << 3) << 48;
}

}  // namespace

std::string LinkChoice::text() const {
    if (pair) return fmt::format("links of @{} and @{}", pair->first, pair->second);
    if (other) return fmt::format("links between `{}` and `{}`", where.text(), other->text());
    return fmt::format("links of `{}`", where.text());
}

bool strikes(Fault fault, double probability, std::uint64_t seed, std::size_t number, std::uint64_t catom, std::int64_t tick) {
    return probability > 0 &&
           drawn(probability, random_bits(seed ^ kFaultSalt, catom | use(fault, number), 0, static_cast<std::uint64_t>(tick)));
}

bool strikes(Fault fault, double probability, std::uint64_t seed, std::size_t number, std::uint64_t a, std::uint64_t b, std::int64_t tick) {
    if (probability <= 0) return false;
    const auto [low, high] = std::minmax(a, b);
    return drawn(probability, random_bits(seed ^ kFaultSalt, low | use(fault, number), high, static_cast<std::uint64_t>(tick)));
}

}  // namespace meld::world
