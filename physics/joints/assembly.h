// Bodies that joints hold together, however indirectly, and these joints as one system J M^-1 J^T, which is solved directly. A body that
// nothing can move belongs to no assembly: joints with it hold on to the world. A composite counts as one body, which has the joints of all
// its members: its mass and inertia act, and the arms of their anchors lead from its centre.
//
// In a substep the impulses act along the rows as they are at its beginning, and are such that the joints hold at its end: what the bodies'
// velocities would do by then is predicted without linearizing it, and the system is solved for the rest until nothing is left. Afterwards,
// as contacts are relaxed, velocities that part the joints in the new places are taken out. Both together keep energy and momentum over
// long times (the method RATTLE of H. C. Andersen, J. Comput. Phys. 52, 1983).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "physics/bodies/bodies.h"
#include "physics/bodies/body_shape.h"
#include "physics/bodies/symmetric.h"
#include "physics/joints/block_system.h"
#include "physics/joints/joint.h"
#include "physics/joints/movers.h"

namespace meld::physics {

// More products of blocks than this in one elimination would take seconds a step. All joints of one body that moves are coupled, which
// takes d (d^2 - 1) / 6 products for d of them.
inline constexpr std::size_t kMostProducts = 20'000'000, kMaxJointsOfBody = 493;
static_assert(kMaxJointsOfBody * (kMaxJointsOfBody * kMaxJointsOfBody - 1) / 6 <= kMostProducts &&
              kMaxJointsOfBody * (kMaxJointsOfBody + 1) * (kMaxJointsOfBody + 2) / 6 > kMostProducts);

// The body in this slot as joints see it.
JointPose joint_pose(const Bodies& bodies, std::uint32_t slot);

class Assembly {
  public:
    enum class Phase {
        // Joints hold at the end of the substep.
        Solve,
        // Joints hold their velocities now.
        Relax,
    };
    // The joints are these of a list, each between two that move apart. False: they have too many loops.
    bool lay_out(std::vector<std::uint32_t> joints, std::span<const Joint> all, const Movers& movers);
    // Bodies have other slots, or composites other places among all.
    void locate(const Movers& movers);
    // In the order of their ids; those that nothing can move follow. A composite has the id of its lowest body.
    struct Member {
        BodyId id;
        std::uint32_t slot;
        bool movable;
        std::uint32_t composite;
    };
    std::span<const Member> members() const { return members_; }
    // By their places in the list; and where the bodies of the first joint are.
    std::span<const std::uint32_t> joints() const { return joints_; }
    std::uint32_t slot_of_first() const { return members_[links_.front().first].slot; }
    std::uint32_t slot_of_second() const { return members_[links_.front().second].slot; }

    void places_changed() { placed_ = false; }
    void warm_start(std::span<Joint> all, const Movers& movers);
    void run(Phase phase, std::span<Joint> all, const Movers& movers, double step_s);
    // What its joints have carried in a step of this length. Returns the one, as an index of the list, that exceeds what it can carry by
    // the greatest factor; of several the first.
    std::optional<std::uint32_t> end_step(std::span<Joint> all, const Movers& movers, double dt_s) const;
    std::size_t bytes() const;

  private:
    struct Body {
        JointPose pose;
        Vec3 velocity, spin;
        double inverse_mass = 0;
        Symmetric inverse_inertia = {};
        // Moments of inertia in its own frame per kg, if they differ; otherwise zeros.
        Vec3 moments = {};
        // How the axes of these moments are turned in the frame of its pose.
        Quat axes = {};
        bool has_other_axes = false;
        Quat principal(Quat turn) const { return has_other_axes ? product(turn, axes) : turn; }
    };
    // A joint as the members see it.
    struct Link {
        std::uint32_t first = 0, second = 0;
        JointRows rows = {};
        std::array<double, kJointRows> errors = {};
        // M^-1 J^T: what an impulse of 1 in a row changes.
        struct Response {
            Vec3 first_velocity, first_spin, second_velocity, second_spin;
        };
        std::array<Response, kJointRows> responses = {};
        // The softness that keeps loops solvable; impulses of the relaxation.
        JointVector softness = JointVector::Zero(), relaxed = JointVector::Zero();
        // All impulses since they were last noted at the joint.
        std::array<double, kJointRows> given = {};
    };
    // The row along which a joint moves: between its limits, which are speeds here, a drive or a spring has the speed `free_speed` without
    // an impulse, one lower by `softness` for each impulse of 1, and at most the impulses +-`most`.
    struct Curve {
        double least_speed, greatest_speed;
        double free_speed = 0, softness = 0, most = 0;
        bool is_spring = false;

        double impulse_at(double speed) const;
        // Where it is at this speed if no limit acts.
        JointStand between_limits(double speed) const;
    };

    bool rests(const Movers& movers) const;
    void load_velocities(const Movers& movers);
    void store(const Movers& movers) const;
    // Places, masses, rows and blocks, if places have changed.
    void place(std::span<Joint> all, const Movers& movers);
    static void read_body(const Member& member, const Movers& movers, Body& body);
    static void read_composite(const Composite& composite, Body& body);
    void see_carried(std::span<const Joint> all, const Movers& movers);
    // A joint as its members carry it.
    const Joint& seen(std::span<const Joint> all, std::size_t link) const { return seen_.empty() ? all[joints_[link]] : seen_[link]; }
    double speed(const Link& link, std::size_t row) const;
    double parting() const;
    void push(Link& link, std::size_t row, double impulse);
    void note_impulses(std::span<Joint> all);
    void predict(const Movers& movers, double step_s);
    Curve curve_of(const Joint& joint, Phase phase, double step_s) const;
    static bool holds(const Joint& joint, const Curve& curve, Phase phase);
    void clamp_drives(std::span<Joint> all);
    void factor(Phase phase, std::span<const Joint> all);
    // What a solution takes for the places at the end of the substep: along straight lines, or as bodies will have turned. Now: none.
    enum class Guess { Straight, Turned, Now };
    void solve_once(Guess guess, std::span<Joint> all, const Movers& movers, double step_s);
    // Brings impulses that do not depend on speeds to what they are; then, after a solution, so many joints at most go along their curves.
    // Returns whether one has.
    void set_given_impulses(std::span<Joint> all);
    bool change_stands(Phase phase, std::span<Joint> all, std::size_t most);
    static JointStand next_stand(const Curve& curve, JointStand stand, double impulse, double speed);

    std::vector<std::uint32_t> joints_;
    // If some member is a composite: all joints in the frames of the members.
    std::vector<Joint> seen_;
    std::vector<Member> members_;
    std::vector<Body> bodies_;
    std::vector<JointPose> predicted_;
    std::vector<Link> links_;
    std::vector<Curve> curves_;
    // Links that share a body that can be moved.
    std::vector<BlockSystem::Pair> pairs_;
    std::vector<std::uint32_t> shared_;
    std::vector<JointBlock> diagonal_, of_pairs_, masked_diagonal_, masked_pairs_;
    std::vector<JointVector> right_;
    // How each row along which a joint moves was part of the factors: not at all, or by its softness.
    std::vector<double> factored_, parts_;
    BlockSystem system_;
    bool placed_ = false, has_loops_ = false, has_factors_ = false;
};

}  // namespace meld::physics
