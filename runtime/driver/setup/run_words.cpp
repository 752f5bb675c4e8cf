#include "runtime/driver/setup/run_words.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

namespace meld::driver {

namespace fs = std::filesystem;

std::vector<std::string> run_words(const RunOptions& run, const std::string& from, const std::string& base) {
    const auto path = [&](const std::string& name) {
        const std::string near = fs::absolute(fs::path(base) / name).lexically_proximate(fs::absolute(from)).string();
        return near.starts_with('-') ? "./" + near : near;
    };
    std::vector<std::string> words = {"meldsim", "run", path(run.program)};
    const auto add = [&](const char* option, const std::string& value) { words.insert(words.end(), {option, value}); };
    if (!run.world.empty()) add("--world", path(run.world));
    for (const auto& [option, files] :
         {std::pair{"--events", &run.events}, {"-I", &run.library_paths}, {"--link", &run.link}, {"--extension", &run.extensions}})
        for (const std::string& file : *files) add(option, path(file));
    for (const auto& [option, values] : {std::pair{"--set", &run.set}, {"--arg", &run.given}, {"--limit", &run.limits}})
        for (const std::string& value : *values) add(option, value);
    if (run.seed >= 0) add("--seed", std::to_string(run.seed));
    if (!run.ports.empty()) add("--ports", run.ports);
    if (run.optimisation) add("-O", std::to_string(*run.optimisation));
    if (run.by_links) words.emplace_back("--by-links");
    if (run.strict) words.emplace_back("--strict");
    if (run.ticks >= 0) add("--ticks", std::to_string(run.ticks));
    if (run.threads > 1) add("--threads", std::to_string(run.threads));
    if (run.timeout_seconds > 0) add("--timeout", fmt::format("{}", run.timeout_seconds));
    for (const BodiesOption& watch : kWatches)
        for (const std::string& body : run.*watch.bodies) add(watch.name, body.ends_with(".meld") ? path(body) : body);
    return words;
}

}  // namespace meld::driver
