// What a body in Meld says after each tick, as a number, for a plot over time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "runtime/base/error.h"
#include "runtime/results/timeline/timeline.h"
#include "runtime/show/view/fields.h"

namespace meld::view {

// Every process of the run has one and asks it the same in the same order. Process 0 has the numbers.
class Series {
  public:
    // {every, ticks, values, done}: after the first tick, then after every so many ticks, and after the last one. The number is the value
    // of a measure (`max D : { dist(A, D) }`, `dist(@3, D)`; null if there is none), 1 or 0 of a body without variables, and of others how
    // many ways there are to satisfy them. Ticks that nobody has asked for are run again beside the timeline, for a fraction of a second:
    // unless `done`, there is more to be had by asking again. Errors: mistakes in the body; it gives several numbers in a tick; a signal
    // has asked for the end.
    Result<Json> ask(timeline::Timeline& timeline, const std::string& body, std::int64_t last, std::int64_t most_points);

    // This tick and later ones are no longer what they were.
    void forget_from(std::int64_t tick);

  private:
    // By tick. Other processes than 0 know only which ticks there are.
    using Numbers = std::map<std::int64_t, std::optional<double>>;
    std::map<std::string, Numbers> bodies_;
};

}  // namespace meld::view
