#include "runtime/driver/questions/diff_command.h"

#include <fmt/format.h>

#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "runtime/base/files/standard_streams.h"
#include "runtime/base/terminal/progress.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/driver/questions/checkpoint_state.h"
#include "runtime/driver/setup/print_error.h"
#include "runtime/results/compare/compare.h"

namespace meld::driver {

namespace {

using compare::Difference;
using compare::Kind;
using compare::LoneTicks;
using compare::PredicateFacts;
using compare::Report;
using Json = nlohmann::ordered_json;

constexpr std::uint64_t kExamples = 3;  // Of facts, but for --json.

bool is_table(Kind kind) { return kind == Kind::CsvFile || kind == Kind::CsvFolder || kind == Kind::Hdf5Facts; }

Result<Report> compare_paths(const DiffOptions& options, const compare::LoadState& load, Progress& progress) {
    const Result<Kind> found_a = compare::kind_of(options.a), found_b = compare::kind_of(options.b);
    for (const auto* each : {&found_a, &found_b})
        if (!*each) return tl::unexpected<Error>(each->error());
    // An empty file is what the other one is.
    const Kind a = *found_a == Kind::Empty ? *found_b : *found_a, b = *found_b == Kind::Empty ? *found_a : *found_b;
    const std::uint64_t examples = options.json ? std::numeric_limits<std::uint64_t>::max() : kExamples;
    const bool text = (a == Kind::TextFacts || a == Kind::Empty) && a == b, empty = *found_a == Kind::Empty || *found_b == Kind::Empty;
    if (text || (is_table(a) && is_table(b) && !empty)) return compare::compare_facts(options.a, a, options.b, b, examples, progress);
    if (a == Kind::Digests && b == a) return compare::compare_digests(options.a, options.b, progress);
    if (a == Kind::Recording && b == a && !empty) return compare::compare_recordings(options.a, options.b, progress);
    if (a == Kind::Checkpoints && b == a && !empty) return compare::compare_checkpoints(options.a, options.b, load, progress);
    return fail(fmt::format("{} and {} cannot be compared: the first is {}, the second is {}", options.a, options.b,
                            compare::name_of(*found_a), compare::name_of(*found_b)),
                "Compare two of a kind; facts as CSV and as HDF5 are of one kind");
}

std::string ticks_text(const LoneTicks& ticks) {
    return ticks.count == 1 ? fmt::format("tick {}", ticks.first) : fmt::format("{} ticks, {} to {}", ticks.count, ticks.first, ticks.last);
}

// As unified diffs are: lines of the first with -, of the second with +.
class Text {
  public:
    std::string of(const DiffOptions& options, const Report& report) {
        add("--- ", options.a);
        add("+++ ", options.b);
        for (const Difference& each : report.runs) section(each.what, each);
        if (report.tick) tick(report);
        if (report.lone_a.count > 0) add("- ", "only here: " + ticks_text(report.lone_a));
        if (report.lone_b.count > 0) add("+ ", "only here: " + ticks_text(report.lone_b));
        for (const PredicateFacts& each : report.facts) {
            if (each.same()) continue;
            section(
                fmt::format("{}: {} in both, {} only in the first, {} only in the second", each.name, each.both, each.only_a, each.only_b),
                {each.name, each.a, each.b}, each.only_a - each.a.size(), each.only_b - each.b.size());
        }
        if (!report.remark.empty()) add("", report.remark);
        return std::move(text_);
    }

  private:
    void add(const char* before, const std::string& line) { text_ += before + visible(line) + "\n"; }
    void section(const std::string& heading, const Difference& each, std::uint64_t more_a = 0, std::uint64_t more_b = 0) {
        add("@@ ", heading + " @@");
        for (const std::string& line : each.a) add("- ", line);
        if (more_a > 0) add("- ", fmt::format("... and {} more", more_a));
        for (const std::string& line : each.b) add("+ ", line);
        if (more_b > 0) add("+ ", fmt::format("... and {} more", more_b));
    }
    void tick(const Report& report) {
        const std::string before = report.same_ticks > 0 ? fmt::format(", after {} that are the same", report.same_ticks) : "";
        if (!report.catom) {
            for (const Difference& each : report.here) section(fmt::format("tick {}{}", *report.tick, before), each);
            return;
        }
        const std::string others =
            report.catoms > 1 ? fmt::format(", the first of {} catoms that differ", report.catoms) : ", the only catom that differs";
        for (const Difference& each : report.here)
            section(fmt::format("tick {}{}; @{}{}: {}", *report.tick, before, *report.catom, others, each.what), each);
    }

    std::string text_;
};

Json to_json(const std::vector<Difference>& all) {
    Json out = Json::array();
    for (const Difference& each : all) out.push_back({{"what", each.what}, {"a", each.a}, {"b", each.b}});
    return out;
}

Json to_json(const LoneTicks& ticks) {
    if (ticks.count == 0) return nullptr;
    return {{"count", ticks.count}, {"first", ticks.first}, {"last", ticks.last}};
}

std::string json_text(const DiffOptions& options, const Report& report) {
    Json facts = Json::array();
    for (const PredicateFacts& each : report.facts)
        facts.push_back({{"predicate", each.name},
                         {"both", each.both},
                         {"only_a", each.only_a},
                         {"only_b", each.only_b},
                         {"a", each.a},
                         {"b", each.b}});
    const Json json = {{"kind", report.kind},
                       {"a", options.a},
                       {"b", options.b},
                       {"same", report.same()},
                       {"runs", to_json(report.runs)},
                       {"ticks_only_a", to_json(report.lone_a)},
                       {"ticks_only_b", to_json(report.lone_b)},
                       {"same_ticks", report.same_ticks},
                       {"tick", report.tick ? Json(*report.tick) : Json()},
                       {"catom", report.catom ? Json(*report.catom) : Json()},
                       {"catoms", report.catoms},
                       {"differences", to_json(report.here)},
                       {"facts", std::move(facts)},
                       {"remark", report.remark}};
    // Escapes text that is not visible, and everything that is not ASCII.
    return json.dump(2, ' ', true, Json::error_handler_t::replace) + "\n";
}

}  // namespace

int diff_command(const DiffOptions& options, const ParseRun& parse) {
    const compare::LoadState load = [&](const sim::Checkpoint& checkpoint) {
        return load_state(checkpoint, [&](const std::vector<std::string>& command) {
            std::optional<RunOptions> run = parse(command);
            if (run) run->quiet = true;
            return run;
        });
    };
    Result<Report> report;
    {
        Progress progress;
        report = compare_paths(options, load, progress);
    }
    if (!report) return print_error(report.error(), "meldsim diff");
    Result<void> printed;
    if (options.json)
        printed = print(stdout, json_text(options, *report));
    else if (!report->same())
        printed = print(stdout, Text().of(options, *report));
    if (!printed) return print_error(printed.error(), "meldsim diff");
    return report->same() ? 0 : kDiffer;
}

}  // namespace meld::driver
