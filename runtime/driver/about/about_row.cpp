#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <span>
#include <string>
#include <utility>

#include "runtime/base/files/input_file.h"
#include "runtime/base/hash.h"
#include "runtime/driver/about/about.h"
#include "runtime/driver/setup/default_world.h"
#include "runtime/driver/setup/run_words.h"
#include "runtime/driver/study/row_store.h"
#include "runtime/driver/study/study_plan.h"
#include "runtime/driver/study/study_table.h"
#include "runtime/world/file/world_file.h"

namespace meld::driver {

namespace {

constexpr std::uint64_t kMostCode_bytes = std::uint64_t{1} << 30;

std::uint64_t hash_of_text_at(const std::string& path) {
    const Result<std::string> text = read_input(path, kMostCode_bytes);
    return text ? hash_text(*text) : 0;
}

// The world with all that it names.
Result<void> add_world(const RunOptions& run, AboutRun& about) {
    if (run.world.empty()) return {};
    const Result<world::World> world = world::read_world(run.world);
    if (!world) return tl::unexpected<Error>(world.error());
    about.world.push_back({run.world, hash_text(world->text)});
    for (const auto* files : {&world->files, &run.events})
        for (const std::string& file : *files) about.world.push_back({file, hash_of_text_at(file)});
    if (!about.seed) about.seed = world->seed;
    return {};
}

}  // namespace

Result<AboutRun> about_row(const std::string& path, const std::string& name, const std::string& folder) {
    Result<Study> study = read_study(path);
    if (!study) return tl::unexpected<Error>(study.error());
    Result<RowStore> store = RowStore::open(results_folder(path, folder));
    if (!store) return tl::unexpected<Error>(store.error());
    const Result<StudyPlan> plan = StudyPlan::make(std::move(*study), store->worlds_folder());
    if (!plan) return tl::unexpected<Error>(plan.error());
    const Result<std::size_t> number = row_named(*plan, name);
    if (!number) return tl::unexpected<Error>(number.error());
    const StudyRow& row = plan->rows()[*number];
    const RunOptions run = plan->options(row);
    const ModuleInfo& module = plan->module_of(row).info();

    AboutRun about{.kind = "row", .name = fmt::format("{}#{}", path, *number + 1)};
    for (const SourceInfo& source : std::span(module.sources, module.source_count))
        about.program.push_back({source.path, hash_text(source.text)});
    about.seed = row.seed;
    if (auto added = add_world(run, about); !added) return tl::unexpected<Error>(added.error());
    for (const auto* files : {&run.link, &run.extensions})
        for (const std::string& file : *files) about.code.push_back({file, hash_of_text_at(file)});
    about.set = row.set;
    about.again = run_words(run, ".");
    about.again.insert(about.again.end(), {"--quiet", "--digest", "-"});
    about.lacks = {"a state: it is counts, measures and a digest", "the program and the world: they are files beside it"};
    const RowResult* const result = store->any(row);
    if (result == nullptr) {
        about.lacks.push_back(fmt::format("anything that was made: nobody has made this row yet. meldsim sweep {} does so", path));
        return about;
    }
    about.made_by = result->made_by;
    if (result->counts.is_object() && !result->counts.empty()) about.counts = result->counts;
    about.tick = result->counts.value("ticks", std::int64_t{0});
    about.digest = result->digest;
    if (about.made_by.is_null()) about.lacks.emplace_back("what made it: an earlier version has made it");
    if (result->digest.empty()) about.lacks.push_back(fmt::format("a digest, since the run has failed: {}", result->reason));
    return about;
}

}  // namespace meld::driver
