#include "runtime/ask/facts/removed_catoms.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <optional>

#include "runtime/sim/simulation.h"

namespace meld::inspect {

namespace {

// Whether a catom has been there and is no more. A number is given only once, so this stays true. Every process calls it.
bool is_gone(sim::Subdomain& subdomain, std::uint64_t id) {
    const std::optional<sim::Catom> catom = subdomain.ensemble.find(id);
    const std::array<std::byte, 1> mine = {std::byte{catom && subdomain.owned(*catom)}};
    const std::vector<std::byte> all = subdomain.comm.allgather(mine);
    return subdomain.has_been(id) && std::ranges::find(all, std::byte{1}) == all.end();
}

}  // namespace

Result<std::string> when_removed(timeline::Timeline& timeline, std::uint64_t catom) {
    if (!is_gone(timeline.simulation().subdomain(), catom)) return std::string();
    const auto gone_at = [&](std::int64_t tick) -> Result<bool> {
        Result<std::unique_ptr<sim::Simulation>> state = timeline.beside(tick);
        if (!state) return tl::unexpected<Error>(state.error());
        return is_gone((*state)->subdomain(), catom);
    };
    std::int64_t there = timeline.first_tick(), gone = timeline.tick();
    const Result<bool> from_the_first = gone_at(there);
    if (!from_the_first) return tl::unexpected<Error>(from_the_first.error());
    if (*from_the_first) return std::string();
    while (gone - there > 1) {
        const std::int64_t middle = there + (gone - there) / 2;
        const Result<bool> already = gone_at(middle);
        if (!already) return tl::unexpected<Error>(already.error());
        (*already ? gone : there) = middle;
    }
    bool region = false;
    for (const world::Event& event : timeline.simulation().subdomain().world.events) {
        if (!event.happens_in(gone)) continue;
        for (const world::CatomChoice& killing : event.kill) {
            if (killing.id == catom) return fmt::format("it was killed in tick {}", gone);
            region = region || !killing.id;
        }
    }
    const bool fault = std::ranges::any_of(timeline.simulation().subdomain().world.faults,
                                           [&](const world::Faults& one) { return one.kill > 0 && one.strikes_in(gone); });
    if (fault && !region) return fmt::format("it went in tick {}, in which faults kill", gone);
    return region ? fmt::format("it went in tick {}, in which an event killed a region", gone) : fmt::format("it went in tick {}", gone);
}

}  // namespace meld::inspect
