#include "runtime/results/profile/description.h"

#include <fmt/format.h>

#include "runtime/base/shallow_json.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/base/units.h"
#include "runtime/results/profile/report.h"
#include "runtime/results/profile/times.h"

namespace meld::profile {

using Json = nlohmann::ordered_json;

Result<Profile> read_whole_profile(const std::string& path) {
    Result<Profile> profile = read_profile(path);
    if (!profile) return profile;
    try {
        describe(*profile);
        trace_events(profile->statistics);
    } catch (const Json::exception& error) {
        return part_missing(path, error);
    }
    return profile;
}

std::string describe(const Profile& profile) {
    const Json& run = profile.run;
    const Json& s = profile.statistics;
    return fmt::format("{} in {}: ticks {} to {}, {} catoms, {} process{} of {} thread{}, {} to run\n",
                       visible(run.at("program").get<std::string>()), visible(run.at("world").get<std::string>()),
                       whole_number<std::int64_t>(s.at("first_tick")), whole_number<std::int64_t>(s.at("last_tick")),
                       whole_number<std::uint64_t>(run.at("catoms")), whole_number<int>(run.at("processes")),
                       run.at("processes") == 1 ? "" : "es", whole_number<int>(run.at("threads")), run.at("threads") == 1 ? "" : "s",
                       format_duration(run.at("run_seconds").get<double>())) +
           time_tables(s) + tables(s);
}

}  // namespace meld::profile
