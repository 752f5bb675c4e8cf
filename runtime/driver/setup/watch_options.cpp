#include "runtime/driver/setup/watch_options.h"

#include <cctype>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/front/watch_rules.h"
#include "compiler/source/source.h"
#include "runtime/ask/why/why.h"
#include "runtime/base/bytes.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/driver/run/replay_without_outputs.h"
#include "runtime/results/timeline/history.h"
#include "runtime/results/timeline/timeline.h"

namespace meld::driver {

namespace {

using front::WatchRule;

bool may_be_name(std::string_view text) {
    for (const char c : text)
        if (!std::isalnum(static_cast<unsigned char>(c)) && c != ' ' && c != '-' && c != '_' && c != '\'') return false;
    return !text.empty();
}

// two leaders: leader(A), leader(B), A <> B
WatchRule typed(std::string text, WatchRule::Verb verb) {
    WatchRule rule{.verb = verb};
    const std::size_t colon = text.find(": ");
    if (colon != std::string::npos && may_be_name(std::string_view(text).substr(0, colon))) {
        rule.name = text.substr(0, colon);
        text.erase(0, text.find_first_not_of(' ', colon + 1));
    }
    rule.body = text;
    rule.asked = {.text = std::move(text)};
    return rule;
}

Result<void> add_file(const std::string& path, std::vector<WatchRule>& rules) {
    source::FileSet files;
    const Result<std::uint32_t> file = files.read(path);
    if (!file) return tl::unexpected<Error>(file.error());
    Result<std::vector<WatchRule>> read = front::read_watch_rules(path, files.file(*file).text());
    if (!read) return tl::unexpected<Error>(read.error());
    for (WatchRule& rule : *read) rules.push_back(std::move(rule));
    return {};
}

}  // namespace

bool names_watch_file(const std::string& text) { return text.ends_with(".meld"); }

Result<std::unique_ptr<inspect::Watches>> make_watches(const RunOptions& options, const ModuleInfo& module, std::FILE* to) {
    std::vector<WatchRule> rules;
    for (const std::string& text : options.watch) {
        if (!names_watch_file(text))
            rules.push_back(typed(text, WatchRule::Verb::Stop));
        else if (auto added = add_file(text, rules); !added)
            return tl::unexpected<Error>(added.error());
    }
    for (const std::string& text : options.expect) rules.push_back(typed(text, WatchRule::Verb::Expect));
    for (const std::string& text : options.never) rules.push_back(typed(text, WatchRule::Verb::Never));
    for (const WatchRule& rule : rules)
        if (rule.asked.text.empty()) return fail("there is nothing to watch", "Give a body: --watch 'leader(A), leader(B), A <> B'");
    if (rules.empty()) return nullptr;
    return inspect::Watches::make(module, std::move(rules), to);
}

Result<void> explain_caught(inspect::Watches& watches, sim::Simulation& simulation, const RunOptions& options, const Inputs& inputs,
                            comm::Communicator& comm) {
    if (!simulation.saveable()) return {};
    const std::int64_t tick = simulation.subdomain().tick();
    const ByteWriter counters = simulation.counters();
    timeline::History kept(0);
    if (auto saved = kept.keep(tick, [&](sim::ShareSink& sink) { return simulation.save(counters.view(), sink); }, comm); !saved)
        return saved;
    const timeline::GatheredShares shares = timeline::GatheredShares::gather(*kept.before(tick)->second, comm);
    const auto make = [&] {
        auto copy = std::make_unique<sim::Simulation>(inputs.info(), inputs.world, inputs.target, comm, options.threads);
        for (const std::string& name : writing_modules(options)) copy->add(std::make_unique<Silent>(), name);
        return copy;
    };
    timeline::Timeline timeline(make, inputs.registry, {.limits = {options.ticks, options.strict}, .history_bytes = 0});
    if (auto there = timeline.start(&shares); !there) return there;
    const auto why = inspect::why_body(timeline, watches.witness(), {.depth = kWitnessDepth, .origins = false});
    if (!why) return tl::unexpected<Error>(why.error());
    Result<void> printed;
    if (comm.process() == 0) printed = watches.explain(*watches.caught_now(), visible(why->to_text()));
    return comm::outcome_of_first(comm, printed);
}

}  // namespace meld::driver
