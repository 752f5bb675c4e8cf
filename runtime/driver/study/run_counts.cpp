#include "runtime/driver/study/run_counts.h"

#include <nlohmann/json.hpp>

#include "runtime/driver/run/report.h"

namespace meld::driver {

nlohmann::ordered_json counts_of(const sim::Summary& s) {
    nlohmann::ordered_json counts = counts_json(s);
    counts["messages"] = s.changes + s.messages;
    std::uint64_t refused = 0;
    for (const sim::Refused& each : s.refused) refused += each.count;
    counts["refused_actions"] = refused;
    return counts;
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
