#include "runtime/driver/questions/profile_command.h"

#include <vector>

#include "runtime/base/files/output_file.h"
#include "runtime/base/files/output_paths.h"
#include "runtime/base/files/standard_streams.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/driver/setup/print_error.h"
#include "runtime/results/profile/description.h"
#include "runtime/results/profile/times.h"

namespace meld::driver {

namespace {

Result<void> show(const ProfileOptions& options) {
    const std::vector<NamedPath> paths = {{"the profile", options.file},
                                          {"--trace", options.trace, NamedPath::Written},
                                          {"--json", options.json ? "-" : "", NamedPath::Written}};
    if (auto distinct = check_distinct(paths); !distinct) return distinct;
    const Result<profile::Profile> profile = profile::read_whole_profile(options.file);
    if (!profile) return tl::unexpected(profile.error());
    if (!options.trace.empty())
        if (auto written = write_file(options.trace, profile::trace_events(profile->statistics)); !written) return written;
    if (options.json) {
        nlohmann::ordered_json json = profile->run;
        json["statistics"] = profile->statistics;
        // The trace is another form of these.
        for (nlohmann::ordered_json& process : json["statistics"]["processes"]) process.erase("spans");
        return print(stdout, json.dump(2, ' ', true) + "\n");
    }
    if (is_standard_output(options.trace)) return {};
    return print(stdout, visible(profile::describe(*profile)));
}

}  // namespace

int profile_command(const ProfileOptions& options) {
    const Result<void> shown = show(options);
    return shown ? 0 : print_error(shown.error());
}

}  // namespace meld::driver
