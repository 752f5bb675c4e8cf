// The engine for millions of bodies: blocks of space, coloured so that blocks of one colour share no body, solved one colour at a time.
//
// A step is a list of stages. Each is a loop over independent blocks, so a caller can run a step stage by stage and exchange velocities
// between processes after each coloured stage (subdomain.h).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "physics/bodies/chunks.h"
#include "physics/bodies/denormals.h"
#include "physics/collision/block_grid.h"
#include "physics/collision/broadphase.h"
#include "physics/solver/composite_rows.h"
#include "physics/solver/contacts.h"
#include "physics/solver/engine.h"
#include "physics/solver/kernels.h"
#include "physics/solver/linked_blocks.h"
#include "physics/solver/load_contacts.h"
#include "physics/solver/shapes/shape_contacts.h"
#include "physics/solver/turning/turning_friction.h"

namespace meld::physics {

// Contacts are searched this far ahead, as a share of the smallest diameter: a body that moves a third of its diameter per tick is stopped
// at the surface instead of inside it.
inline constexpr double kLookAheadShare = 0.02;

// Fast bodies meet obstacles on their way in this and the next step: after the last substep a relaxation sweep stops those that would touch
// in the next step.
inline constexpr double kStepsAhead = 2;

class BlockEngine final : public Engine {
  public:
    explicit BlockEngine(World& world) : world_(world) {}

    Result<StepReport> step(const StepTimes& times, Workers& workers) override;
    void structure_changed() override { rebuild_ = true; }
    void body_changed(std::uint32_t slot, bool moved) override;
    void gravity_changed() override;
    void state_restored() override;
    bool asleep(std::uint32_t slot) const override;
    bool divided() const override { return static_cast<bool>(owns_); }
    void each_contact(const ContactVisitor& visit) const override;
    void add_normal_forces(std::span<ExactSum> of_slot, Workers& workers) const override;
    std::size_t bytes() const override;
    double residual() override;
    std::size_t awake_bodies() const override { return report().awake_bodies; }
    Home home(std::uint32_t slot) const override;
    std::vector<std::uint32_t> slots_of(Home home, std::span<const std::uint32_t> known) const override;
    void save_home(Home home, ByteWriter& bodies, ByteWriter& contacts) const override;
    Result<void> load_home(Home home, std::uint32_t first, Holds holds, ByteReader& bodies, ByteReader& contacts) override;
    void save_rest(ByteWriter& out) const override;
    void load_rest(ByteReader& in) override;
    Result<void> loaded(Workers& workers) override;

    // The stages of a step, to be run in order.
    std::vector<Stage> plan(const StepTimes& times) const;
    Result<void> run(const Stage& stage, const StepTimes& times, Workers& workers);
    StepReport report() const;
    // The result of the last stage FindBounces: the colours of the blocks with contacts that would bounce, as bits.
    std::uint8_t bouncing_colours() const { return bouncing_colours_; }

    // Before a rebuild, with the same argument on all subdomains: the velocities of the whole world's bodies.
    void set_velocities(const Velocities& all, const StepTimes& times);
    const BlockGrid& grid() const { return grid_; }
    bool must_rebuild(const StepTimes& times) const { return rebuild_ || list_is_old(times); }

  private:
    friend class Subdomain;

    // The state of a block besides its bodies.
    struct BlockState {
        // The greatest speed in the last tick, infinite if unknown; the greatest drift since the candidate list was made.
        float speed_squared = 0;
        float drift_squared = 0;
        std::uint16_t still_ticks = 0;
        // When to decide whether it stays: after this many still ticks, if the greatest speed of their last quarter is not well above that
        // of the second, and no body's velocity has changed steadily since half of them. A body that begins to roll or to be pulled speeds
        // up, however slowly, and one that turns round at the end of its way slows down and speeds up again.
        std::uint16_t decide_at = 0;
        float first_speed_squared = 0, second_speed_squared = 0;
        bool stays = false;
        // This block and all blocks around it stay.
        bool rests = false;
        bool asleep = false;
        // This subdomain solves its pairs; false for blocks that another subdomain owns.
        bool owned = true;
        // Awake, or asleep next to an awake block: its contacts are solved.
        bool active = true;
    };

    // A body that moves in a block where nearly all are still: where it was when the engine began to watch it, and its greatest speed
    // since.
    struct Rattler {
        std::uint32_t slot;
        Drift at;
        float peak_squared;
    };
    struct Cages {
        std::vector<Rattler> rattlers;
        std::uint64_t since_tick = 0;
        int watch_ticks = 0;
        // How many times one after the other all were found to be caged.
        int confirmed = 0;
        // A body that turns round once comes not far in one watch, but in the next.
        bool are_sure() const { return confirmed >= 2; }
    };

    // A block that came from a snapshot: its bodies are in the slots from `first` on.
    // How far a fast body may go before the next list.
    struct Path {
        std::uint32_t slot;
        float length_m;
    };
    struct LoadedBlock {
        std::uint64_t key = 0;
        std::uint32_t first = 0, count = 0;
        BlockState state = {};
        // Slots are counted from the first of the block.
        std::optional<Cages> cages = {};
        std::vector<Path> paths = {};
        std::span<const std::byte> contacts = {}, shape_contacts = {};  // Valid until loaded().
    };
    struct Loading {
        GridShape shape;
        std::vector<LoadedBlock> blocks;
    };

    Result<void> prepare(const StepTimes& times, Workers& workers);
    bool list_is_old(const StepTimes& times) const;
    // Whether a body of a block goes farther than the list has looked.
    bool leaves_path(std::uint32_t block, double dt_s) const;
    void list_paths();
    // Before a list: whether it is to serve several steps. Then it says in what time, and in which frame.
    bool follow_paths(const Velocities& all, const StepTimes& times);
    std::span<const Path> paths_of(std::uint32_t block) const;
    Result<void> rebuild(const StepTimes& times, Workers& workers);
    void keep_last_good(Workers& workers);
    RadiusRange radii_of_world() const;
    // Half of the least thickness of all bodies, which of spheres is the least radius.
    double least_radius_m(const RadiusRange& radii) const;
    // How the next rebuild will divide space.
    GridShape next_shape() const;
    // The speed below which a body counts as still in steps of this length.
    double still_speed_m_s(double dt_s) const;
    void count_still_ticks(double dt_s);
    // Whether the bodies of this block that are not still are few, slow, and have not left their cages for long.
    bool only_rattles(std::uint32_t block, float still_squared, double dt_s);
    // In a block that is watched: keeps its bodies' velocities, and later whether one has changed steadily since.
    void mark_velocities(std::uint32_t block, double still_speed_m_s);
    bool turns_or_speeds_up(std::uint32_t block, double still_speed_m_s) const;
    // The stillness of a new block's bodies.
    void resume_stillness(BlockState& state, std::uint16_t still_ticks) const;
    bool has_moving_fixed_body(std::uint32_t block) const;
    void note_stillness();
    // Slots have changed: drops what is stored by block.
    void forget_blocks();
    void keep_pushed_awake(const StepTimes& times);
    void find_resting();
    // In a divided world with joints or composites: what this subdomain says of their blocks, to be added to what the others say. Which are
    // linked, and which do not stay; then which do not rest; then what all have said.
    void say_links_and_stays();
    void say_rests();
    void hear_rests();
    void update_sleep();
    Result<void> settle(const StepTimes& times, Workers& workers);
    void cache_contacts(Workers& workers);
    void list_blocks();
    void set_asleep(std::uint32_t block, bool asleep);
    void begin_actuation(double dt_s, Workers& workers);
    void actuate_block(std::uint32_t block);
    // Gaps and normals of the contacts of these blocks, from the present positions: of a new list, within a step, and at its end.
    enum class After : std::uint8_t { List, Substep, Step };
    Result<void> refresh(const std::vector<std::uint32_t>& blocks, const StepTimes& times, Workers& workers, After after);
    // The error: a body that ODE fails at or that is too deep in an obstacle, and the message; of several, that of the lowest body.
    tl::expected<void, std::pair<BodyId, Error>> refresh_obstacles(int worker, std::uint32_t block, double dt_s);
    template <class Fails>
    int surfaces_near(int worker, std::uint32_t slot, std::uint32_t obstacle, double dt_s,
                      std::array<SurfaceContact, kMaxSurfaceContacts>& surfaces, const Fails& fails);
    Result<void> move(const StepTimes& times, Workers& workers);
    void find_events(Workers& workers);
    void find_bounces(const BounceRule& rule, Workers& workers);
    // Gaps and normals of pairs of fast bodies that are still apart: those of the place where they will meet.
    void refresh_fast(std::uint32_t block, double dt_s);
    void bounce_block(std::uint32_t block, const BounceRule& rule);
    // Contacts of composites, which are few when they bounce: one after the other, in the order of blocks, each with the whole mass.
    bool find_composite_bounces(const BounceRule& rule, Workers& workers);
    void bounce_composites(const BounceRule& rule, std::uint32_t block);
    // Those in which they bounce, in order.
    std::vector<std::uint32_t> blocks_of_composite_bounces() const;
    // Which blocks sleep and wake together, because a composite has members in them.
    void link_blocks();
    // Whether any subdomain has joints.
    bool has_joints() const { return owns_ ? divided_joints_ : !world_.joints.empty(); }
    // Whether any subdomain of a divided world has composites: all know all connections.
    bool shares_composites() const { return divided() && !world_.composites.connections().empty(); }
    // Clears the flag of a block where one that is linked with it has none.
    void all_or_none(std::vector<std::uint8_t>& of_block) const;
    void let_composites_sleep();
    // Loads, if somebody wants them: before a step; and at the end of a substep, if one has begun.
    bool loads_wanted() const { return world_.loads.wanted() && !world_.composites.all().empty(); }
    void begin_loads();
    void collect_loads();
    void add_joint_loads();
    void break_joints(double dt_s, Workers& workers);
    void solve_block(std::uint32_t block, const SweepRule& rule, int sweeps, float step_s);
    // Friction against rolling and spinning (turning/turning_friction.cpp), if some material has it.
    void lay_out_turning_friction(Workers& workers);
    void resist_turning(std::uint32_t block, const SweepRule& rule, float step_s);
    // Prescribed motions: the velocities in a substep that begins, and the places at its end (motions/block_motions.cpp).
    void prescribe_velocities(const StepTimes& times, Workers& workers);
    void prescribe_places(const StepTimes& times);
    // Whether a body is so near to an obstacle with a belt that it may touch it.
    bool is_by_belt(std::uint32_t block) const;
    // Obstacles that move (motions/obstacle_lanes.cpp): puts them where they are as a substep of this step begins, with the velocities in
    // it. Where they were when the list was made, and where they are now; and whether one has gone farther than the list allows for.
    void place_obstacles(const StepTimes& times, int substep);
    void begin_list_of_obstacles(double ahead_s);
    void restore_list_of_obstacles();
    bool has_obstacle_left_list() const;
    // The entries of their contacts' lanes after new batches, and what those of a block have as velocities.
    void lay_out_obstacle_lanes();
    void move_obstacle_lanes(std::uint32_t block);
    void move_all_obstacle_lanes(Workers& workers);
    // Whether a body of a block may be met by one in this step.
    bool may_be_met(std::uint32_t block, const StepTimes& times) const;
    // Bodies with shapes (block_shapes.cpp).
    ShapeContacts::Setup shape_setup() const;
    void lay_out_shapes(const PairSearch::Reach& reach, double ahead_s, const std::vector<bool>* wanted, Workers& workers);
    void turn_shapes_by_torques(std::uint32_t block, const Wrench* first, const Wrench* second, double step_s);
    Moved move_shaped(std::uint32_t block, float step_s);
    std::optional<std::pair<BodyId, Error>> refresh_shapes(std::uint32_t block, double dt_s, bool followed);
    // Calls f(batch, lane, what it is) for each lane that is used.
    template <class F>
    void each_shape_lane(std::size_t block, const F& f) const;
    Touch touch_of_lane(const ShapeBatch& batch, int i, const ShapeLane& lane) const;
    void find_shape_events(std::uint32_t block, float near_m, float far_m, Chunks<TouchEvent>& events);
    // Those that touch, with the force of all their points.
    void each_shape_touch(std::size_t block, const std::function<void(const ShapeBatch&, int, const ShapeLane&, double)>& visit) const;
    void report_shape_contacts(std::size_t block, const ContactVisitor& visit) const;
    // Calls pair(batch, lane, normal force) for each two bodies of the block that touch, and obstacle(batch, lane, normal force, obstacle
    // lane) for each body that touches an obstacle.
    template <class Pair, class Obstacle>
    void each_touch(std::size_t block, const Pair& pair, const Obstacle& obstacle) const;
    double list_reach_m() const { return margin_m_ + skin_m_; }
    double reach_m() const;

    tl::unexpected<Error> too_deep(std::uint32_t block);

    // Calls f(worker, block) for the blocks of a list.
    template <class F>
    static void for_blocks(const std::vector<std::uint32_t>& list, Workers& workers, const F& f);

    World& world_;
    BlockGrid grid_;
    Contacts contacts_;
    CompositeRows rows_;
    ShapeContacts shape_contacts_;
    // Empty unless some material resists, and between a new list and the next step.
    TurningFriction turning_;
    // If somebody wants the loads of connections; fresh while it follows the list of contacts.
    LoadContacts load_contacts_;
    bool load_contacts_fresh_ = false;
    // By block, if composites have contacts that bounce: which blocks have them.
    std::vector<std::uint8_t> composites_bounce_;
    // In a divided world: of these blocks they bounce in the present round.
    std::vector<std::uint32_t> composites_bounce_now_;
    // By block: the first of those that it is linked with; empty without composites.
    std::vector<std::uint32_t> linked_;
    // In a divided world, by block: whether it has bodies with joints or members of composites; and which of all such blocks are linked.
    std::vector<std::uint8_t> has_joined_;
    LinkedBlocks all_links_;
    std::vector<BlockState> states_;
    // By block, where some are watched.
    std::unordered_map<std::uint32_t, Cages> cages_;
    std::vector<Wrench> feature_wrenches_;
    std::vector<std::uint32_t> awake_, active_;
    std::array<std::vector<std::uint32_t>, kColours> coloured_;
    double smallest_radius_m_ = 0.5;
    double skin_m_ = 0, margin_m_ = 0;
    // The list holds what fast bodies may meet in this time, relative to a frame that moves.
    double ahead_s_ = 0;
    double farthest_path_m_ = 0;
    Vec3 frame_m_s_;
    // Whether the list serves fast bodies until they have gone these ways besides, in the order of slots; others may go half of the skin.
    bool follows_paths_ = false;
    std::vector<Path> paths_;
    double last_dt_s_ = 0;
    double last_substep_s_ = 0;
    // Whether this subdomain owns a block; empty if the world is not divided.
    std::function<bool(BlockCoordinates)> owns_;
    bool divided_joints_ = false;
    std::uint8_t bouncing_colours_ = 0;
    Loading loading_;
    bool composites_fine_ = true, joints_fine_ = true;
    bool cached_ = false;
    // Those of the present step that are over.
    int substep_ = 0;
    // The tick in which the list was made.
    std::uint64_t list_tick_ = 0;
    // In a divided world: composites have been made anew before the step; copies must take their mean when those of all are here.
    bool recomposed_before_ = false, average_due_ = false;
    bool rebuild_ = true, fresh_ = false, forget_ = false, rebuilt_in_step_ = false, recomposed_in_step_ = false;
};

// Several blocks make a job, so that small blocks are not all overhead, but few enough that all workers have some.
template <class F>
void BlockEngine::for_blocks(const std::vector<std::uint32_t>& list, Workers& workers, const F& f) {
    constexpr std::size_t kMaxBlocksPerJob = 16;
    const std::size_t per_job =
        std::clamp<std::size_t>(list.size() / (4 * static_cast<std::size_t>(workers.threads())), 1, kMaxBlocksPerJob);
    workers.run((list.size() + per_job - 1) / per_job, [&](int worker, std::size_t job) {
        const FlushDenormals flush;
        const std::size_t end = std::min(list.size(), (job + 1) * per_job);
        for (std::size_t i = job * per_job; i < end; ++i) f(worker, list[i]);
    });
}

}  // namespace meld::physics
