// What a world says that fails: which catoms and links an event strikes, and what strikes them by chance. All draws are functions of the
// seed, the ids of the catoms and the tick, so they are the same on any number of processes.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/world/shapes/shape.h"

namespace meld::world {

// Catoms: those in a region, or one by its number.
struct CatomChoice {
    std::optional<std::uint64_t> id = {};  // Otherwise those in the region.
    Region where = {};
    std::string place = {};
};

// Links: that of two catoms by their numbers; those between two regions; or those of catoms in a region.
struct LinkChoice {
    std::optional<std::pair<std::uint64_t, std::uint64_t>> pair = {};
    Region where = {};
    std::optional<Region> other = {};
    std::string place = {};

    // Whether it is the link of these catoms; in(region, end) says whether the first (0) or the second (1) is in a region.
    template <class In>
    bool contains(std::uint64_t a, std::uint64_t b, const In& in) const {
        if (pair) return *pair == std::pair(a, b) || *pair == std::pair(b, a);
        if (other) return (in(where, 0) && in(*other, 1)) || (in(where, 1) && in(*other, 0));
        return in(where, 0) || in(where, 1);
    }
    // "the link of @3 and @4", "the links between `x < 0` and `x > 0`".
    std::string text() const;
};

// Links over which nothing arrives for a while.
struct Jam {
    LinkChoice links;
    std::int64_t ticks = 1;
};

// What strikes by chance: the probability that it strikes a catom or a link in a tick.
struct Faults {
    double kill = 0, hang = 0, restart = 0;  // Catoms.
    double cut = 0, heal = 0;                // Links.
    Region where = {};
    std::string place = {};
    std::int64_t from = 1;
    std::int64_t until = std::numeric_limits<std::int64_t>::max();  // The last tick.

    bool strikes_in(std::int64_t tick) const { return tick >= from && tick <= until; }
    bool strikes_catoms() const { return kill > 0 || hang > 0 || restart > 0; }
    bool strikes_links() const { return cut > 0 || heal > 0; }
};

enum class Fault : std::uint64_t { Kill, Hang, Restart, Cut, Heal };
// Whether a fault strikes with this probability in a tick: a catom, or the link of two, in any order. `number` is that of the [[faults]].
// Cost: a draw of random numbers, none if it never does.
bool strikes(Fault fault, double probability, std::uint64_t seed, std::size_t number, std::uint64_t catom, std::int64_t tick);
bool strikes(Fault fault, double probability, std::uint64_t seed, std::size_t number, std::uint64_t a, std::uint64_t b, std::int64_t tick);

}  // namespace meld::world
