// What a run did in each of its ticks, in numbers, as far as it has been made.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

#include "runtime/show/view/fields.h"
#include "runtime/sim/simulation.h"

namespace meld::view {

class Metrics {
  public:
    // After a tick that has been made for the first time. What was known of later ticks was of a run that is no more.
    void note(sim::Simulation& simulation);

    // {ticks: [...], series: {catoms: [...], ...}}: at most so many points. Of more ticks, each point stands for as many as `every` says,
    // and has the greatest of their numbers.
    Json json(std::size_t most_points) const;

  private:
    struct Numbers {
        std::uint64_t catoms = 0, evaluated = 0, derivations = 0, changes = 0, messages = 0, actions = 0;
    };
    std::map<std::int64_t, Numbers> ticks_;
};

}  // namespace meld::view
