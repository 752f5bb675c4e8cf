#include "runtime/sim/watchers/thermometer.h"

#include <fmt/format.h>

#include "runtime/base/hash.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

// A day has 24 ticks; it is 10.0 to 25.9 degrees, in tenths.
Result<void> Weather::step(Subdomain& subdomain) {
    const auto day = static_cast<std::uint64_t>(subdomain.tick() / 24);
    today_ = 10.0 + static_cast<double>(hash_combine(seed_, day) % 160) / 10.0;
    return {};
}

std::string Weather::status() const { return fmt::format("{:.1f} degrees today", today_); }

}  // namespace meld::sim
