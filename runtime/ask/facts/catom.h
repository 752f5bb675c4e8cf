// What there is to know of one catom beside its facts: where it is, what it touches, and what is under way to it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "runtime/sim/core/subdomain.h"

namespace meld::inspect {

struct CatomState {
    struct Link {
        std::int64_t port = 0;
        u64 catom = 0;
    };
    struct Coming {
        std::string fact;       // As Meld writes it.
        std::int64_t tick = 0;  // In which its rules see it.
    };
    u64 id = 0;
    std::optional<std::array<std::int64_t, 3>> cell = {};  // On a lattice,
    std::array<double, 3> position = {};                   // and in diameters.
    std::vector<Link> links = {};                          // By port.
    std::vector<std::string> actions = {};                 // Asked for in this tick, and carried out in the next.
    std::vector<Coming> coming = {};                       // Facts that wait, or that have just been given.
};

// On process 0, and nothing if there is no such catom; every process calls it. On the others nothing.
std::optional<CatomState> find_catom(sim::Subdomain& subdomain, u64 id);

}  // namespace meld::inspect
