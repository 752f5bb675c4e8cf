#include "runtime/show/view/metrics.h"

#include <algorithm>
#include <utility>

namespace meld::view {

void Metrics::note(sim::Simulation& simulation) {
    const sim::Subdomain& subdomain = simulation.subdomain();
    const sim::Totals& totals = subdomain.totals;
    ticks_.erase(ticks_.lower_bound(subdomain.tick()), ticks_.end());
    ticks_[subdomain.tick()] = {.catoms = totals.catoms,
                                .evaluated = totals.tick.awake,
                                .derivations = totals.tick.derivations,
                                .changes = totals.tick.changes,
                                .messages = totals.tick.messages,
                                .actions = totals.actions};
}

Json Metrics::json(std::size_t most_points) const {
    const std::size_t every = std::max<std::size_t>(1, (ticks_.size() + most_points - 1) / most_points);
    Json ticks = Json::array(), series = Json::object();
    constexpr std::pair<const char*, std::uint64_t Numbers::*> kSeries[] = {
        {"catoms", &Numbers::catoms},   {"evaluated", &Numbers::evaluated}, {"derivations", &Numbers::derivations},
        {"changes", &Numbers::changes}, {"messages", &Numbers::messages},   {"actions", &Numbers::actions}};
    for (const auto& [name, member] : kSeries) series[name] = Json::array();
    std::size_t i = 0;
    for (const auto& [tick, numbers] : ticks_) {
        const bool begins = i++ % every == 0;
        if (begins) ticks.push_back(tick);
        for (const auto& [name, member] : kSeries) {
            Json& values = series[name];
            if (begins)
                values.push_back(numbers.*member);
            else
                values.back() = std::max(values.back().get<std::uint64_t>(), numbers.*member);
        }
    }
    return {{"every", every}, {"ticks", std::move(ticks)}, {"series", std::move(series)}};
}

}  // namespace meld::view
