#include "runtime/driver/study/run_counts.h"

#include <nlohmann/json.hpp>

namespace meld::driver {

nlohmann::ordered_json counts_of(const sim::Summary& s) {
    std::uint64_t refused = 0;
    for (const sim::Refused& each : s.refused) refused += each.count;
    return {{"ticks", s.ticks},
            {"messages", s.changes + s.messages},
            {"exported_changes", s.changes},
            {"linear_messages", s.messages},
            {"dropped_messages", s.dropped},
            {"far_facts", s.far_facts},
            {"far_messages", s.far_hops},
            {"catoms", s.catoms},
            {"evaluations", s.evaluations},
            {"derivations", s.derivations},
            {"refused_actions", refused},
            {"killed", s.killed},
            {"hung", s.hung},
            {"restarted", s.restarted},
            {"lost_linear_facts", s.lost},
            {"links_cut", s.links_cut},
            {"links_made", s.links_made},
            {"nodes_made", s.nodes_made}};
}

const std::vector<std::string_view>& count_names() {
    static const nlohmann::ordered_json kNone = counts_of({});
    static const std::vector<std::string_view> kNames = [] {
        std::vector<std::string_view> names;
        for (const auto& [name, value] : kNone.items()) names.emplace_back(name);
        return names;
    }();
    return kNames;
}

}  // namespace meld::driver
