#include "runtime/driver/setup/command_line.h"

#include <fmt/format.h>

#include <utility>

namespace meld::driver {

std::vector<std::string> command_line(const RunOptions& run) {
    std::vector<std::string> words = {"meldsim", "run", run.program.starts_with('-') ? "./" + run.program : run.program};
    const auto add = [&](const char* option, const std::string& value) {
        if (!value.empty()) words.push_back(fmt::format("{}={}", option, value));
    };
    const auto add_all = [&](const char* option, const std::vector<std::string>& values) {
        for (const std::string& value : values) {
            words.push_back(fmt::format("{}{}{}", option, value.empty() ? "" : "=", value));
            // After `--arg=` the next word would be the value.
            if (value.empty()) words.emplace_back();
        }
    };
    add("--world", run.world);
    add_all("--library", run.library_paths);
    if (run.ticks >= 0) add("--ticks", std::to_string(run.ticks));
    add("--processes", std::to_string(run.processes));
    add("--threads", std::to_string(run.threads));
    add_all("--set", run.set);
    add_all("--limit", run.limits);
    add_all("--arg", run.given);
    add_all("--link", run.link);
    add_all("--extension", run.extensions);
    add_all("--events", run.events);
    if (run.optimisation) words.push_back(fmt::format("-O{}", *run.optimisation));
    if (run.seed >= 0) add("--seed", std::to_string(run.seed));
    add("--ports", run.ports);
    for (const OutputOption& output : kOutputs) add(output.name, run.*output.path);
    for (const BodiesOption& watch : kWatches) add_all(watch.name, run.*watch.bodies);
    add("--checkpoint", run.checkpoint);
    add("--checkpoint-every", run.checkpoint_every);
    add("--retries", std::to_string(run.retries));
    add("--heartbeat", run.heartbeat);
    add("--balance", run.balance);
    if (run.timeout_seconds > 0) add("--timeout", fmt::format("{}", run.timeout_seconds));
    for (const auto& [option, on] : {std::pair{"--strict", run.strict},
                                     {"--by-links", run.by_links},
                                     {"--checkpoint-changes", run.checkpoint_changes},
                                     {"--sync", run.sync},
                                     {"--stats", run.stats},
                                     {"--json", run.json},
                                     {"--quiet", run.quiet}})
        if (on) words.emplace_back(option);
    add("--forked-from", run.fork);
    return words;
}

}  // namespace meld::driver
