// The implementations that come with Claymeld, by interface and name.
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "runtime/base/did_you_mean.h"
#include "runtime/module/abi/actions.h"
#include "runtime/sim/bodies/free_motion.h"
#include "runtime/sim/choices.h"
#include "runtime/sim/core/extension.h"
#include "runtime/sim/core/subdomain.h"
#include "runtime/sim/lattice/lattice_motion.h"
#include "runtime/sim/lattice/possible_moves.h"
#include "runtime/sim/points/point_motion.h"
#include "runtime/sim/watchers/thermometer.h"

namespace meld::sim {

namespace {

// Catoms do not move.
class NoMotion : public SimModule {
  public:
    Result<void> start(Subdomain& subdomain) override { return check_nothing_possible(subdomain); }
    Result<void> step(Subdomain& subdomain) override {
        refuse_those_of_other_worlds(subdomain, ActionInfo::Performer::None);
        return {};
    }
    Result<void> saveable() const override { return {}; }
    bool leaves_facts_alone(const Subdomain&) const override { return true; }
    bool divides_anew() const override { return true; }
};

}  // namespace

bool Registry::may_give(const world::World& world) const {
    const auto gives = [&](const auto& chosen) {
        const auto choice = choose(chosen.first, chosen.second);
        return choice && !std::holds_alternative<MakeCode>(*choice);
    };
    const std::string& motion = world.motion.kind;
    return (motion != "none" && motion != "lattice" && motion != "amoebot" && motion != "bodies" && motion != "points") ||
           std::ranges::any_of(world.components, gives);
}

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
    r.add_sim("motion", "none", [](const world::World& w) -> Result<std::unique_ptr<SimModule>> {
        // What nodes sense of those in range is given by the same module, whether they move or not.
        if (w.links) return std::make_unique<PointMotion>(w);
        return std::make_unique<NoMotion>();
    });
    r.add_sim("motion", "points",
              [](const world::World& w) -> Result<std::unique_ptr<SimModule>> { return std::make_unique<PointMotion>(w); });
    for (const char* kind : {"lattice", "amoebot"})
        r.add_sim("motion", kind,
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
