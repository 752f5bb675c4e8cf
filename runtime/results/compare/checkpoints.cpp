// Checkpoints: what the runs are, by their manifests, and then the states, catom by catom.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>

#include "runtime/results/compare/compare.h"

namespace meld::compare {

namespace {

// The newest tick that both have, or the newest of each.
std::array<std::int64_t, 2> ticks_to_compare(const std::vector<std::int64_t>& a, const std::vector<std::int64_t>& b) {
    std::vector<std::int64_t> both;
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
    return both.empty() ? std::array{a.back(), b.back()} : std::array{both.back(), both.back()};
}

std::vector<Difference> traits(const sim::RunIdentity& a, const sim::RunIdentity& b) {
    std::vector<Difference> out;
    const auto find = [](const sim::RunIdentity& run, const std::string& name) -> const sim::Trait* {
        const auto at = std::find_if(run.traits.begin(), run.traits.end(), [&](const sim::Trait& t) { return t.name == name; });
        return at == run.traits.end() ? nullptr : &*at;
    };
    for (const sim::Trait& one : a.traits) {
        const sim::Trait* const other = find(b, one.name);
        if (other == nullptr)
            out.push_back({one.name, {one.shown}, {}});
        else if (other->hash != one.hash && other->shown != one.shown)
            out.push_back({one.name, {one.shown}, {other->shown}});
        else if (other->hash != one.hash)
            out.push_back({one.name,
                           {fmt::format("{}, with the hash {:016x}", one.shown, one.hash)},
                           {fmt::format("{}, with the hash {:016x}", other->shown, other->hash)}});
    }
    for (const sim::Trait& one : b.traits)
        if (find(a, one.name) == nullptr) out.push_back({one.name, {}, {one.shown}});
    // Another program has another module, of which there is nothing to tell.
    const auto of = [](const char* name) { return [name](const Difference& each) { return each.what == name; }; };
    if (std::any_of(out.begin(), out.end(), of("the program"))) std::erase_if(out, of("the module"));
    return out;
}

// Which catoms differ: the least, and how many.
void compare_catoms(const std::vector<State::Catom>& a, const std::vector<State::Catom>& b, Report& report) {
    for (std::size_t i = 0, j = 0; i < a.size() || j < b.size();) {
        const bool first = i < a.size() && (j == b.size() || a[i].id <= b[j].id);
        const bool second = j < b.size() && (i == a.size() || b[j].id <= a[i].id);
        if (!(first && second && a[i].hash == b[j].hash)) {
            if (report.catoms++ == 0) report.catom = first ? a[i].id : b[j].id;
        }
        i += first ? 1 : 0;
        j += second ? 1 : 0;
    }
}

// Loads a state at a time: the catoms of the one, those of the other with its lines, and the lines of the one.
Result<void> compare_states(const std::array<sim::Checkpoint, 2>& checkpoints, const LoadState& load, Report& report, Progress& progress) {
    const auto loading = [&](std::size_t which) {
        progress.update([&] { return fmt::format("loading the checkpoint of tick {}", checkpoints[which].manifest.tick); });
        return load(checkpoints[which]);
    };
    std::vector<State::Catom> catoms_a;
    {
        const Result<std::unique_ptr<State>> a = loading(0);
        if (!a) return tl::unexpected(a.error());
        catoms_a = (*a)->catoms();
    }
    std::vector<std::string> lines_b;
    {
        const Result<std::unique_ptr<State>> b = loading(1);
        if (!b) return tl::unexpected(b.error());
        compare_catoms(catoms_a, (*b)->catoms(), report);
        if (report.catom) lines_b = (*b)->lines(*report.catom);
    }
    if (!report.catom) return {};
    catoms_a = {};
    const Result<std::unique_ptr<State>> a = loading(0);
    if (!a) return tl::unexpected(a.error());
    const std::vector<std::string> lines_a = (*a)->lines(*report.catom);
    Difference one{"state", {}, {}};
    std::set_difference(lines_a.begin(), lines_a.end(), lines_b.begin(), lines_b.end(), std::back_inserter(one.a));
    std::set_difference(lines_b.begin(), lines_b.end(), lines_a.begin(), lines_a.end(), std::back_inserter(one.b));
    report.here = {std::move(one)};
    return {};
}

}  // namespace

Result<Report> compare_checkpoints(const std::string& a, const std::string& b, const LoadState& load, Progress& progress) {
    const std::array<std::int64_t, 2> ticks = ticks_to_compare(sim::checkpoint_ticks(a), sim::checkpoint_ticks(b));
    Result<sim::Checkpoint> first = sim::checkpoint_of(a, ticks[0]), second = sim::checkpoint_of(b, ticks[1]);
    for (const auto* each : {&first, &second})
        if (!*each) return tl::unexpected(each->error());
    const std::array<sim::Checkpoint, 2> checkpoints = {std::move(*first), std::move(*second)};
    const sim::Manifest &x = checkpoints[0].manifest, &y = checkpoints[1].manifest;
    Report report{.kind = "checkpoints", .runs = traits(x.run, y.run)};
    if (x.tick != y.tick) report.runs.push_back({"the tick", {std::to_string(x.tick)}, {std::to_string(y.tick)}});
    if (x.digest == y.digest) {
        if (x.tick == y.tick) report.same_ticks = 1;
        return report;
    }
    report.tick = std::max(x.tick, y.tick);
    report.here = {{"digest", {x.digest}, {y.digest}}};
    if (const auto compared = compare_states(checkpoints, load, report, progress); !compared) {
        if (compared.error().code == ExitCode::RecordingRefused) return tl::unexpected(compared.error());
        report.remark = fmt::format("Which catoms differ cannot be told: {}", compared.error().message());
    }
    return report;
}

}  // namespace meld::compare
