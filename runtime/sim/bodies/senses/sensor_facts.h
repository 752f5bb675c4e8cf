// Facts of what numbered sensors on a catom show, name(A, Sensor, Value): one of each sensor that shows something.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "runtime/module/abi/senses.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

class SensorFacts {
  public:
    // Finds the predicate that stores what the program reads, if it does.
    void start(const Subdomain& subdomain, BodyQuantity quantity);
    bool active() const { return predicate_.has_value(); }
    // What a sensor of a catom shows, if anything, and whether it differs enough from what was shown last.
    using Measure = std::function<std::optional<double>(Catom, std::size_t sensor)>;
    using Differs = std::function<bool(double last, double now)>;
    // Writes what has changed at the catoms of this process, on all workers. Cost: a call for each sensor of each of them.
    void sense(Subdomain& subdomain, std::size_t sensors, const Measure& measure, const Differs& differs) const;

  private:
    // Returns whether a fact has changed.
    bool sense_catom(Subdomain& subdomain, std::size_t sensors, const Measure& measure, const Differs& differs, Catom catom,
                     int worker) const;

    std::optional<u32> predicate_;
    u64 dirty_ = 0;
};

}  // namespace meld::sim
