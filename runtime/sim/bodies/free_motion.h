// [motion] kind = "bodies": catoms are bodies that fall, touch, roll and pull, moved by the physics between the ticks of their
// programs.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "runtime/sim/bodies/body_actions.h"
#include "runtime/sim/bodies/body_senses.h"
#include "runtime/sim/bodies/contact_links.h"
#include "runtime/sim/bodies/divided_bodies.h"
#include "runtime/sim/bodies/fixed_touches.h"
#include "runtime/sim/bodies/physics_scene.h"
#include "runtime/sim/core/extension.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

class FreeMotion : public SimModule {
  public:
    explicit FreeMotion(const world::World& world) : world_(world) {}
    Result<void> start(Subdomain& subdomain) override;
    // Carries out the actions of the last tick, moves the bodies for the time of a tick, and updates what the programs sense.
    Result<void> step(Subdomain& subdomain) override;
    void finish(Subdomain& subdomain) override;
    std::string status() const override;
    std::string outcome() const override;
    Stages stages() const override;

  private:
    // The scene, alike on all processes, with the bodies of this one.
    Result<void> make_scene(Subdomain& subdomain);
    Result<void> step_once(Subdomain& subdomain);
    // After the first step: puts what began to touch in it beside the touches of catoms that nothing moves.
    void note_fixed_touches(const Subdomain& subdomain);
    Result<physics::StepReport> move(Subdomain& subdomain);
    // Catoms below the lowest height that the world allows end the run, or go.
    Result<void> lose_catoms(Subdomain& subdomain);
    // What the last step reports, without catoms that are lost.
    std::span<const physics::TouchEvent> events();
    // Bodies and their catoms go to the processes whose blocks they are in; whether any did.
    Result<bool> hand_over(Subdomain& subdomain, double step_s, int substeps);

    const world::World& world_;
    PhysicsScene physics_;
    BodyActions actions_;
    BodySenses senses_;
    ContactLinks links_;
    std::optional<DividedBodies> divided_;
    std::vector<physics::TouchEvent> fixed_touches_;  // Of this process, until they have become links.
    std::uint64_t bodies_ = 0, awake_ = 0;
    std::uint64_t crossed_ = 0;                // Catoms that have come to another process, without those that did before anything moved.
    std::vector<physics::BodyId> lost_;        // In the last tick, on all processes; sorted.
    std::vector<physics::TouchEvent> events_;  // Where some are lost.
    std::uint64_t lost_count_ = 0;
    bool moved_ = false;
    double energy_j_ = 0;
    double handing_over_s_ = 0, linking_s_ = 0, sensing_s_ = 0;
};

}  // namespace meld::sim
