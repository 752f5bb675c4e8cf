// The actions `attach` and `detach`, by which programs make joints and take them off.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "runtime/module/abi/actions.h"
#include "runtime/sim/bodies/contact_links.h"
#include "runtime/sim/bodies/physics_scene.h"
#include "runtime/sim/core/refusals.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

// An action of this tick; the kind is that of an `attach`.
struct AskedJoint {
    ActionKind action = ActionKind::None;
    Catom catom = 0;
    std::uint64_t other = 0;
    std::int64_t kind = 0;
};
struct RefusedJoint {
    ActionKind action = ActionKind::None;
    Catom catom = 0;
    Refusal why = Refusal::NotJoined;
};

// Pairs of catoms, the lower number first; sorted. On all processes alike.
struct ChangedJoints {
    // Joints that are new, and those of them whose catoms were no neighbours.
    std::vector<physics::ConnectionPair> made, strangers;
    std::vector<physics::ConnectionPair> ended;
};

class JointChanges {
  public:
    explicit JointChanges(const world::World& world) : world_(world) {}

    // Whether the program asks for any; the same on all processes.
    static bool asks(const Subdomain& subdomain);
    // Errors: it does, and the engine of the world has no joints that begin later.
    Result<void> check(const Subdomain& subdomain) const;

    // Carries out the actions of a tick, in any order with the same result: which joints there are, and where the catoms are, is judged as
    // the tick found them. Of several who ask for the same two catoms, the one with the lowest number goes first, and of kinds that it
    // asks for the first. `refused` gets those of this process. Every process calls it, and all make and end all joints; `links` has the
    // touches of this one.
    ChangedJoints carry_out(Subdomain& subdomain, PhysicsScene& physics, const ContactLinks& links, std::span<const AskedJoint> asked,
                            std::vector<RefusedJoint>& refused) const;

  private:
    // An `attach` as all processes know it.
    struct Wish {
        physics::BodyId body, other;
        std::uint32_t kind;
        std::uint32_t linked;
        auto operator<=>(const Wish&) const = default;
    };
    // A catom that somebody wants a joint with or for.
    struct End {
        physics::BodyId id = 0;
        bool fixed = false;
        physics::JointPose pose = {};
        double radius_m = 0;
        physics::BodyShape shape = {};
    };
    using Ends = std::map<physics::BodyId, End>;

    void sort_out(Subdomain& subdomain, const PhysicsScene& physics, const ContactLinks& links, std::span<const AskedJoint> asked,
                  std::vector<Wish>& wishes, std::vector<physics::ConnectionPair>& ended, std::vector<RefusedJoint>& refused) const;
    static std::vector<Wish> gather_wishes(Subdomain& subdomain, const std::vector<Wish>& ours);
    static Ends find_ends(Subdomain& subdomain, const physics::Scene& scene, const std::vector<Wish>& wishes);

    const world::World& world_;
};

}  // namespace meld::sim
