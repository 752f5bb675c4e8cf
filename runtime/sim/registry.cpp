// The implementations that come with Claymeld, by interface and name.
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "runtime/abi/actions.h"
#include "runtime/base/bytes.h"
#include "runtime/base/nearest.h"
#include "runtime/sim/bodies/free_motion.h"
#include "runtime/sim/choices.h"
#include "runtime/sim/core/extension.h"
#include "runtime/sim/core/subdomain.h"
#include "runtime/sim/lattice/lattice_motion.h"
#include "runtime/sim/watchers/thermometer.h"

namespace meld::sim {

namespace {

// Catoms do not move. Warns if a program requested moves.
class NoMotion : public SimModule {
  public:
    Result<void> after(Subdomain& subdomain) override {
        for (const eval::Action& a : subdomain.actions())
            refused_ += info(subdomain.kind_of(a)).performer == ActionInfo::Performer::Lattice;
        return {};
    }
    Result<void> saveable() const override { return {}; }
    void save_rest(const Subdomain&, ByteWriter& out) const override { out.write(refused_); }
    // The counts of all processes become one.
    Result<void> load_rest(Subdomain& subdomain, ByteReader& in) override {
        const auto theirs = in.read<std::uint64_t>();
        if (subdomain.comm.process() == 0) refused_ += theirs;
        return {};
    }
    void finish(Subdomain& subdomain) override {
        ByteWriter bytes;
        bytes.write(refused_);
        const std::vector<std::byte> all = subdomain.comm.allgather(bytes.view());
        ByteReader in(all, "counts of refused moves");
        refused_ = 0;
        for (int p = 0; p < subdomain.comm.processes(); ++p) refused_ += in.read<std::uint64_t>();
    }
    std::string outcome() const override {
        return refused_ == 0
                   ? ""
                   : fmt::format(
                         "warning: {} actions asked for a move, and nothing moves in this world: give it [motion] kind = \"lattice\"",
                         refused_);
    }

  private:
    std::uint64_t refused_ = 0;
};

}  // namespace

Result<Registry::Choice> Registry::choose(const std::string& interface, const std::string& name) const {
    std::vector<std::string_view> interfaces, names;
    std::optional<Choice> found;
    const auto look = [&](const auto& all) {
        for (const auto& [known, implementations] : all) {
            if (std::find(interfaces.begin(), interfaces.end(), known) == interfaces.end()) interfaces.push_back(known);
            if (known != interface) continue;
            for (const auto& [implementation, make] : implementations) {
                names.push_back(implementation);
                if (implementation == name) found = make;
            }
        }
    };
    look(sims_);
    look(codes_);
    look(components_);
    if (found) return *found;
    if (names.empty()) return fail("there is no interface '" + interface + "'", did_you_mean(interface, interfaces));
    return fail(fmt::format("there is no implementation '{}' of {}", name, interface), did_you_mean(name, names));
}

Result<void> check_choices(const Registry& registry, const world::World& world) {
    if (const auto found = registry.choose("motion", world.motion.kind); !found)
        return fail(world.path + ": [motion] kind: " + found.error().problem, found.error().suggestion);
    for (const auto& [interface, name] : world.components)
        if (const auto found = registry.choose(interface, name); !found)
            return fail(world.path + ": [components] " + found.error().problem, found.error().suggestion);
    return {};
}

Registry Registry::standard() {
    Registry r;
    r.add_sim("motion", "none", [](const world::World&) -> Result<std::unique_ptr<SimModule>> { return std::make_unique<NoMotion>(); });
    r.add_sim("motion", "lattice",
              [](const world::World& w) -> Result<std::unique_ptr<SimModule>> { return std::make_unique<LatticeMotion>(w); });
    r.add_sim("motion", "bodies",
              [](const world::World& w) -> Result<std::unique_ptr<SimModule>> { return std::make_unique<FreeMotion>(w); });
    r.add_code("thermometer", "plane",
               [](const world::World&) -> Result<std::unique_ptr<CodeModule>> { return std::make_unique<PlaneThermometer>(); });
    r.add_code("thermometer", "drift",
               [](const world::World&) -> Result<std::unique_ptr<CodeModule>> { return std::make_unique<DriftingThermometer>(); });
    r.add_component("thermometer", "weather",
                    [](const world::World& w) -> Result<std::unique_ptr<Component>> { return std::make_unique<Weather>(w.seed); });
    return r;
}

}  // namespace meld::sim
