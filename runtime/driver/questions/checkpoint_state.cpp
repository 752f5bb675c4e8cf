#include "runtime/driver/questions/checkpoint_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <filesystem>
#include <system_error>
#include <utility>

#include "runtime/base/hash.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/driver/run/checkpoints.h"
#include "runtime/driver/run/run.h"
#include "runtime/driver/run/run_configuration.h"
#include "runtime/driver/setup/inputs.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/results/facts/fact_tables.h"
#include "runtime/sim/bodies/saved_places.h"
#include "runtime/sim/core/subdomain.h"
#include "runtime/sim/state/loader.h"
#include "runtime/sim/state/share_file.h"

namespace meld::driver {

namespace {

class LoadedState : public compare::State {
  public:
    LoadedState(Inputs inputs, std::unique_ptr<comm::Communicator> comm)
        : inputs_(std::move(inputs)), comm_(std::move(comm)), subdomain_(inputs_.info(), inputs_.world, inputs_.target, *comm_, 1) {}

    Result<void> load(const sim::Shares& shares) { return sim::Loader(subdomain_, shares).facts(sim::place_saved_bodies); }

    std::vector<Catom> catoms() const override {
        std::vector<Catom> out;
        const world::Ensemble& ensemble = subdomain_.ensemble;
        for (sim::Catom c = 0; c < ensemble.index_count(); ++c)
            if (subdomain_.owned(c)) out.push_back({ensemble.id(c), hash_text(place(c)) + facts_hash(c)});
        std::sort(out.begin(), out.end(), [](const Catom& x, const Catom& y) { return x.id < y.id; });
        return out;
    }

    std::vector<std::string> lines(std::uint64_t id) const override {
        const std::optional<sim::Catom> catom = subdomain_.ensemble.find(id);
        if (!catom) return {};
        std::vector<std::string> out = {place(*catom)};
        each_shown([&](u32 index, const PredicateInfo& p) {
            tuple::each_fact(subdomain_.module, subdomain_.columns, subdomain_.geometry(), index, *catom,
                             [&](const Value* v) { out.push_back(tuple::print_fact(subdomain_.module, p, id, v)); });
        });
        std::sort(out.begin(), out.end());
        return out;
    }

  private:
    template <class Visit>
    void each_shown(const Visit& visit) const {
        for (u32 i = 0; i < subdomain_.module.predicate_count; ++i)
            if (const PredicateInfo& p = subdomain_.module.predicates[i]; record::shown(p)) visit(i, p);
    }
    std::string place(sim::Catom c) const {
        const world::Ensemble& ensemble = subdomain_.ensemble;
        if (!ensemble.is_free()) {
            const auto cell = ensemble.cell(c);
            return fmt::format("in cell ({}, {}, {})", cell.x, cell.y, cell.z);
        }
        const world::Vec3& at = ensemble.position(c);
        return fmt::format("at ({}, {}, {})", at[0], at[1], at[2]);
    }
    // In any order of the facts.
    std::uint64_t facts_hash(sim::Catom c) const {
        std::uint64_t sum = 0;
        each_shown([&](u32 index, const PredicateInfo& p) {
            const u64 start = hash_combine(hash_text(p.name), p.arity);
            tuple::each_fact(subdomain_.module, subdomain_.columns, subdomain_.geometry(), index, c,
                             [&](const Value* v) { sum += mix64(tuple::hash_arguments(subdomain_.module, p, start, v)); });
        });
        return sum;
    }

    Inputs inputs_;
    std::unique_ptr<comm::Communicator> comm_;
    sim::Subdomain subdomain_;
};

// Paths in the command of a run are as of the folder where it was started.
class InFolder {
  public:
    explicit InFolder(const std::string& folder) : before_(std::filesystem::current_path()) {
        std::filesystem::current_path(folder, error);
    }
    ~InFolder() {
        std::error_code none;
        std::filesystem::current_path(before_, none);
    }
    InFolder(const InFolder&) = delete;
    InFolder& operator=(const InFolder&) = delete;

    std::error_code error;

  private:
    std::filesystem::path before_;
};

}  // namespace

Result<std::unique_ptr<compare::State>> load_state(const sim::Checkpoint& checkpoint, const ParseRun& parse) {
    const sim::Manifest& manifest = checkpoint.manifest;
    std::optional<RunOptions> options = parse(manifest.run.command);
    if (!options) return fail("the command of the run is not one of this version of meldsim");
    options->command = manifest.run.command;
    const Result<sim::ShareFiles> shares = sim::ShareFiles::open(checkpoint.files);
    if (!shares) return tl::unexpected<Error>(shares.error());
    const InFolder folder(manifest.run.folder);
    if (folder.error) return fail(fmt::format("the folder {} cannot be entered: {}", manifest.run.folder, folder.error.message()));
    const Result<std::string> module = compile_program(*options);
    if (!module) return fail(module.error().problem.empty() ? "the program cannot be compiled" : module.error().problem);
    auto comm = comm::make_single();
    Result<Inputs> inputs = read_inputs(*options, *comm, *module);
    if (!inputs) return fail(inputs.error().problem, inputs.error().suggestion);
    if (const auto counted = count_catoms(*options, *comm, *inputs); !counted)
        return fail(counted.error().problem, counted.error().suggestion);
    const sim::RunIdentity now = identity(*options, claims(*options, inputs->module, inputs->world), inputs->world);
    if (const std::string other = sim::difference(manifest.run, now); !other.empty()) return fail(other);
    auto state = std::make_unique<LoadedState>(std::move(*inputs), std::move(comm));
    if (const auto loaded = state->load(*shares); !loaded) return tl::unexpected<Error>(loaded.error());
    return state;
}

}  // namespace meld::driver
