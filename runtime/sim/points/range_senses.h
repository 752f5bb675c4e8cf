// What nodes sense of neighbours within their range: how far away they are, and in which direction. Stored for programs that read it.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/module/abi/senses.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

class RangeSenses {
  public:
    explicit RangeSenses(const world::RangeOptions& options) : options_(options) {}
    // Finds what the program reads.
    void start(const Subdomain& subdomain);
    // All nodes of this process sense their neighbours as they are now. A value that was measured of the same two places is the same again,
    // and others have an error of their own, by the seed. Cost: a look at each link, on all workers; nothing if the program reads nothing.
    void sense(Subdomain& subdomain) const;
    // These only.
    void sense(Subdomain& subdomain, std::span<const Catom> catoms) const;

  private:
    struct Sensor {
        RangeQuantity quantity = RangeQuantity::Distance;
        u32 predicate = 0;
        u64 dirty = 0;
    };
    // What a catom has sensed of a neighbour.
    struct Reading {
        u64 other = 0;
        std::array<double, 3> at = {};
        auto operator<=>(const Reading&) const = default;
    };
    // Returns the dirty bits of what has changed.
    u64 sense_catom(Subdomain& subdomain, Catom catom, int worker) const;
    Reading measure(const Subdomain& subdomain, RangeQuantity quantity, Catom catom, Catom other) const;

    const world::RangeOptions options_;
    std::vector<Sensor> sensors_;
};

}  // namespace meld::sim
