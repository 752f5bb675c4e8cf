// Those who read over the links of a catom, some at a time.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "runtime/world/ensemble/ensemble.h"

namespace meld::sim {

// Of one link: who reads over it, at which of its ports, and where, or -1; and the port of the catom that is read.
struct Reader {
    world::Catom catom;
    world::Port port;
    std::int32_t index;
    world::Port from;
};

// At most so many at a time.
inline constexpr world::Port kReadersAtOnce = 16;

// Whether each_readers() finds out where readers read, which costs most of it.
enum class Looks { WhoReads, AndWhere };

// Calls visit(readers) for the readers at each so many ports of a catom; there may be none. They lie anywhere in memory: all of them are
// looked up before any is needed.
template <Looks looks = Looks::AndWhere, class Visit>
void each_readers(const world::Links& links, world::Catom catom, const Visit& visit) {
    std::array<Reader, kReadersAtOnce> readers;
    const world::Port ports = links.ports(catom);
    for (world::Port first = 0; first < ports; first += kReadersAtOnce) {
        std::size_t count = 0;
        for (world::Port port = first; port < std::min(ports, first + kReadersAtOnce); ++port)
            if (const auto reader = links.at(catom, port)) readers[count++] = {*reader, links.port_there(catom, port), -1, port};
        if (looks == Looks::AndWhere)
            for (std::size_t i = 0; i < count; ++i) readers[i].index = links.read(readers[i].catom, readers[i].port);
        visit(std::span<const Reader>(readers.data(), count));
    }
}

// Calls visit(reader, port, other, index) for all links over which catoms of this process read; `index` is where.
template <class Visit>
void each_link_read(const world::Ensemble& ensemble, const Visit& visit) {
    for (world::Catom reader = 0; reader < ensemble.index_count(); ++reader) {
        if (ensemble.state(reader) != kCatomOwned) continue;
        ensemble.links().each(reader, [&](world::Port port, world::Catom other) {
            if (const std::int32_t index = ensemble.links().read(reader, port); index >= 0)
                visit(reader, port, other, static_cast<world::Catom>(index));
        });
    }
}

}  // namespace meld::sim
