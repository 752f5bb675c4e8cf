#include "runtime/driver/outputs.h"

#include <vector>

#include "runtime/base/output_paths.h"
#include "runtime/record/recording.h"

namespace meld::driver {

namespace {

Durability durability(const RunOptions& options) { return options.sync ? Durability::Machine : Durability::Process; }

Result<void> open_one(const std::string& path, Appears appears, Durability durability, std::optional<OutputFile>& file) {
    if (path.empty()) return {};
    auto opened = OutputFile::open(path, appears, durability);
    if (!opened) return tl::unexpected(opened.error());
    file.emplace(std::move(*opened));
    return {};
}

}  // namespace

Result<void> check_outputs(const RunOptions& options, const std::string& world) {
    std::vector<NamedPath> paths = {{"the program", options.program}, {"the world", world}};
    for (const std::string& file : options.link) paths.push_back({"--link", file});
    for (const std::string& file : options.extensions) paths.push_back({"--extension", file});
    paths.push_back({"--facts-out", options.facts_out, NamedPath::Written});
    paths.push_back({"--digest", options.digest, NamedPath::Written});
    paths.push_back({"--json", options.json ? "-" : "", NamedPath::Written});
    paths.push_back({"--record", options.record, NamedPath::Written});
    if (!options.record.empty())
        for (const char* sidecar : {record::kSidecar, record::kLinesSidecar})
            paths.push_back({"the sidecar of --record", options.record + sidecar, NamedPath::Written});
    return check_distinct(paths);
}

Result<void> open_outputs(const RunOptions& options, Outputs& outputs) {
    if (auto opened = open_one(options.facts_out, Appears::Whole, durability(options), outputs.facts); !opened) return opened;
    return open_one(options.digest, Appears::AtOnce, durability(options), outputs.digest);
}

bool results_at_standard_output(const RunOptions& options) {
    for (const std::string& path : {options.facts_out, options.digest})
        if (path == "-" || path == "/dev/stdout") return true;
    return options.json;
}

}  // namespace meld::driver
