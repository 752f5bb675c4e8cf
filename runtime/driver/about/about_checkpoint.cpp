#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <string>

#include "runtime/driver/about/about.h"
#include "runtime/driver/setup/run_words.h"
#include "runtime/sim/state/checkpoint_folder.h"

namespace meld::driver {

namespace {

const sim::Trait* trait(const sim::RunIdentity& run, std::string_view name) {
    for (const sim::Trait& each : run.traits)
        if (each.name == name) return &each;
    return nullptr;
}

}  // namespace

Result<AboutRun> about_checkpoint(const std::string& folder, const ParseRun& parse) {
    const Result<sim::Manifest> manifest = sim::newest_manifest(folder);
    if (!manifest) return tl::unexpected<Error>(manifest.error());
    const sim::RunIdentity& run = manifest->run;
    AboutRun about{.kind = "checkpoint", .name = folder};
    if (const sim::Trait* program = trait(run, "the program")) about.program.push_back({program->shown, program->hash});
    if (const sim::Trait* world = trait(run, "the world")) about.world.push_back({world->shown, world->hash});
    if (const sim::Trait* code = trait(run, "--extension"); code != nullptr && !code->shown.empty())
        about.code.push_back({code->shown, code->hash});
    if (const sim::Trait* set = trait(run, "the parameters"); set != nullptr && !set->shown.empty()) about.set.push_back(set->shown);
    if (const sim::Trait* seed = trait(run, "the seed")) {
        std::uint64_t number = 0;
        if (std::from_chars(seed->shown.data(), seed->shown.data() + seed->shown.size(), number).ec == std::errc{}) about.seed = number;
    }
    about.made_by = object_in(manifest->made_by);
    if (const sim::Trait* version = trait(run, "the version of Claymeld"); version != nullptr && about.made_by.is_null())
        about.made_by = {{"claymeld", version->shown}};
    about.counts = object_in(manifest->counts);
    about.tick = manifest->tick;
    about.digest = manifest->digest;
    about.folder = run.folder;
    about.typed = run.command;
    if (std::optional<RunOptions> options = parse(run.command)) {
        options->ticks = manifest->tick;
        options->timeout_seconds = 0;
        // They change nothing of the state, but that a watch ends the run in its last tick.
        for (const BodiesOption& watch : kWatches) (*options.*watch.bodies).clear();
        about.again = run_words(*options, ".", run.folder);
        about.again.insert(about.again.end(), {"--quiet", "--digest", "-"});
        about.limits = options->limits;
    }
    about.lacks = {"the text of its program and its world, and their files: only their hashes",
                   "the ticks before: it is the state after one tick",
                   "the compiled module, the compiler and the MPI library: only their versions"};
    if (about.again.empty()) about.lacks.emplace_back("a command that makes it again from the start: its run branched off from another");
    return about;
}

}  // namespace meld::driver
