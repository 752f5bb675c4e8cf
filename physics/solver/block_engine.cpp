// The stages of a step over blocks.
#include "physics/solver/block_engine.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <numeric>
#include <optional>

#include "physics/collision/broadphase.h"
#include "physics/collision/meeting.h"
#include "physics/solver/feature_wrenches.h"
#include "physics/solver/kernels.h"
#include "runtime/base/assert.h"
#include "runtime/base/release_memory.h"

namespace meld::physics {

namespace {

constexpr std::size_t kSlotsPerJob = 16384;
// A blow passes through about two touching bodies per sweep; the rest after the last sweep is stopped without restitution.
constexpr int kBounceSweeps = 4;

// Bodies that travel less far than this while a list is used, as a share of the smallest diameter, are found in time although they may
// overlap a little.
constexpr double kSlowShare = 0.375;

// Where few bodies are fast, a list is to serve so many steps, as long as no body travels farther than a smallest diameter in them, and at
// most this share of all bodies farther than half of the skin.
constexpr int kStepsOfList = 8;
constexpr double kFewShare = 1.0 / 32;

// A new list holds what fast bodies may meet in the step, and what a relaxation sweep then keeps from touching in the next substep.
double ahead_of_fast_s(const StepTimes& times) { return times.dt_s + times.substep_s(); }

float squared(double value) { return static_cast<float>(value * value); }

}  // namespace

std::vector<Stage> BlockEngine::plan(const StepTimes& times) const {
    using Kind = Stage::Kind;
    const SolverSettings& solver = world_.settings.solver;
    const bool soft = solver.mode == SolverMode::Soft, bounces = world_.bounces();
    std::vector<Stage> stages;
    const auto coloured = [&](Kind kind) {
        for (int colour = 0; colour < kColours; ++colour) stages.push_back({.kind = kind, .colour = colour});
    };
    // Before anything that would change the approach: the sweeps of a solver without restitution, and the relaxation sweep.
    const auto bounce = [&] {
        for (int left = bounces ? kBounceSweeps : 0; left > 0; --left) {
            const int stages_of_sweep = 1 + kColours + (shares_composites() ? 1 : 0);
            stages.push_back({.kind = Kind::FindBounces, .bounce_stages = left * stages_of_sweep - 1});
            coloured(Kind::Bounce);
            if (shares_composites()) stages.push_back({.kind = Kind::BounceComposites});
        }
    };
    const bool joins = has_joints();
    stages.push_back({.kind = Kind::Prepare, .shares_links = (joins && divided()) || shares_composites()});
    stages.push_back({.kind = Kind::FindResting});
    stages.push_back({.kind = Kind::UpdateSleep});
    if (world_.has_features()) coloured(Kind::Actuate);
    bounce();
    for (int substep = 0; substep < times.substeps; ++substep) {
        stages.push_back({.kind = Kind::Accelerate});
        if (soft) coloured(Kind::WarmStart);
        if (soft && joins) stages.push_back({.kind = Kind::WarmStartJoints});
        for (int sweep = 0; sweep < solver.sweeps; ++sweep) {
            coloured(Kind::Solve);
            if (joins) stages.push_back({.kind = Kind::SolveJoints});
        }
        stages.push_back({.kind = Kind::Move});
        stages.push_back({.kind = Kind::Refresh, .goes_on = substep + 1 < times.substeps});
        bounce();
        for (int sweep = 0; soft && sweep < solver.relax_sweeps; ++sweep) {
            coloured(Kind::Relax);
            if (joins) stages.push_back({.kind = Kind::RelaxJoints});
        }
    }
    if (shares_composites() && world_.loads.wanted()) stages.push_back({.kind = Kind::ShareLoads});
    stages.push_back({.kind = Kind::Finish});
    return stages;
}

Result<StepReport> BlockEngine::step(const StepTimes& times, Workers& workers) {
    const std::vector<Stage> stages = plan(times);
    for (std::size_t i = 0; i < stages.size(); ++i) {
        if (auto done = run(stages[i], times, workers); !done) return tl::unexpected(done.error());
        if (stages[i].must_agree()) i += static_cast<std::size_t>(stages[i].left_out(bouncing_colours_));
    }
    return report();
}

Result<void> BlockEngine::run(const Stage& stage, const StepTimes& times, Workers& workers) {
    MELD_EXPECT(times.dt_s > 0 && times.substeps > 0, "{} s in {} substeps", times.dt_s, times.substeps);
    MELD_EXPECT(stage.colour < kColours && stage.kind <= Stage::Kind::Finish, "colour {}", stage.colour);
    Rules rules = rules_for(world_.settings, times, 2 * smallest_radius_m_);
    Bodies& bodies = world_.bodies;
    const Wrench* const wrenches = bodies.wrenches.empty() ? nullptr : bodies.wrenches.data();
    const Wrench* const feature_wrenches = world_.has_features() ? feature_wrenches_.data() : nullptr;
    rules.bounce.wrenches[0] = wrenches, rules.bounce.wrenches[1] = feature_wrenches;
    const auto over_colour = [&](const auto& f) {
        for_blocks(coloured_[static_cast<std::size_t>(stage.colour)], workers, [&](int, std::uint32_t block) { f(block); });
    };
    // Velocities of composites are in their copies while colours are swept.
    const auto sweep_colour = [&](const auto& f) {
        if (stage.colour == 0) {
            rows_.begin(contacts_, shape_contacts_, active_, bodies, world_.composites, workers);
            shape_contacts_.prepare(active_, bodies, workers);
        }
        over_colour(f);
        if (!stage.ends_sweep()) return;
        if (divided())
            average_due_ = true;
        else
            rows_.average(bodies, workers);
    };
    if (std::exchange(average_due_, false)) rows_.average(bodies, workers);
    // Joints act on composites, not on their copies.
    const auto sweep_joints = [&](Assembly::Phase phase) {
        const StageClock clock(world_.times.solve);
        rows_.collect(bodies, world_.composites, workers);
        world_.joints.run(phase, world_.movers(), times.substep_s(), workers);
    };
    switch (stage.kind) {
        case Stage::Kind::Prepare:
            return prepare(times, workers);
        case Stage::Kind::FindResting:
            find_resting();
            return {};
        case Stage::Kind::UpdateSleep:
            return settle(times, workers);
        case Stage::Kind::WarmStartJoints: {
            const StageClock clock(world_.times.solve);
            rows_.collect(bodies, world_.composites, workers);
            world_.joints.warm_start(world_.movers(), workers);
            return {};
        }
        case Stage::Kind::SolveJoints:
            sweep_joints(Assembly::Phase::Solve);
            return {};
        case Stage::Kind::RelaxJoints:
            sweep_joints(Assembly::Phase::Relax);
            return {};
        case Stage::Kind::Actuate: {
            const StageClock clock(world_.times.actuation);
            if (stage.colour == 0) begin_actuation(times.dt_s, workers);
            over_colour([&](std::uint32_t block) { actuate_block(block); });
            return {};
        }
        case Stage::Kind::Accelerate: {
            rows_.collect(world_.bodies, world_.composites, workers);
            collect_loads();
            load_contacts_.begin_substep();
            if (!turning_.empty()) turning_.begin_substep(contacts_, shape_contacts_, active_);
            world_.composites.accelerate(wrenches, feature_wrenches, bodies, rules.move, workers);
            // A cold solver begins each substep from zero: impulses that bodies have not felt would otherwise count.
            if (world_.settings.solver.mode == SolverMode::Pgs) {
                contacts_.forget(workers);
                shape_contacts_.forget_impulses();
                world_.joints.forget_impulses();
            }
            const StageClock clock(world_.times.move);
            for_blocks(awake_, workers, [&](int, std::uint32_t block) {
                accelerate(bodies.velocity.data(), bodies.place.data(), wrenches, feature_wrenches, grid_.blocks()[block].first,
                           grid_.blocks()[block].count, rules.move);
                if (!world_.shapes.empty()) turn_shapes_by_torques(block, wrenches, feature_wrenches, times.substep_s());
            });
            return {};
        }
        case Stage::Kind::WarmStart: {
            const StageClock clock(world_.times.solve);
            sweep_colour([&](std::uint32_t block) {
                warm_start(contacts_.plain_pairs(block), bodies.velocity.data());
                warm_start(contacts_.plain_obstacles(block), bodies.velocity.data());
                rows_.warm_start(contacts_, block, bodies.velocity.data());
                shape_contacts_.warm_start(block, bodies.velocity.data());
            });
            return {};
        }
        case Stage::Kind::Solve: {
            const StageClock clock(world_.times.solve);
            sweep_colour(
                [&](std::uint32_t block) { solve_block(block, rules.solve, world_.settings.solver.inner_sweeps, rules.move.step_s); });
            return {};
        }
        case Stage::Kind::Relax: {
            const StageClock clock(world_.times.solve);
            if (stage.colour == 0 && loads_wanted()) load_contacts_.before_relaxation(shape_contacts_, bodies);
            sweep_colour([&](std::uint32_t block) { solve_block(block, rules.relax, 1, rules.move.step_s); });
            return {};
        }
        case Stage::Kind::FindBounces: {
            const StageClock clock(world_.times.solve);
            if (loads_wanted()) load_contacts_.before_bounces(contacts_);
            find_bounces(rules.bounce, workers);
            return {};
        }
        case Stage::Kind::Bounce: {
            const StageClock clock(world_.times.solve);
            // Something bounces, here or elsewhere.
            if (loads_wanted()) load_contacts_.before_points(shape_contacts_, bodies);
            over_colour([&](std::uint32_t block) { bounce_block(block, rules.bounce); });
            if (stage.colour != kColours - 1 || divided()) return {};
            for (const std::uint32_t block : blocks_of_composite_bounces()) bounce_composites(rules.bounce, block);
            return {};
        }
        case Stage::Kind::BounceComposites: {
            const StageClock clock(world_.times.solve);
            for (const std::uint32_t block : composites_bounce_now_) bounce_composites(rules.bounce, block);
            return {};
        }
        case Stage::Kind::ShareLoads:
            collect_loads();
            return {};
        case Stage::Kind::Move:
            return move(times, workers);
        case Stage::Kind::Refresh:
            return refresh(active_, times, workers, stage.goes_on ? After::Substep : After::Step);
        case Stage::Kind::Finish: {
            if (world_.has_features()) account_charges(world_, workers);
            rows_.collect(world_.bodies, world_.composites, workers);
            world_.composites.set_velocities(bodies, workers);
            if (loads_wanted()) {
                collect_loads();
                world_.loads.add_noted(world_.composites);
                add_joint_loads();
                world_.loads.end_step(world_.composites, wrenches, feature_wrenches, world_.settings.gravity_m_s2, times.dt_s);
            }
            find_events(workers);
            break_joints(times.dt_s, workers);
            last_dt_s_ = times.dt_s, last_substep_s_ = times.substep_s();
            return {};
        }
    }
    return {};
}

// What they held begins to collide.
void BlockEngine::break_joints(double dt_s, Workers& workers) {
    world_.joints.end_step(world_.movers(), dt_s, workers);
    for (const auto& [one, other] : world_.joints.broken()) {
        world_.composites.joined().remove(one, other);
        structure_changed();
        for (const BodyId body : {one, other}) body_changed(world_.bodies.slot(body), false);
    }
}

void BlockEngine::solve_block(std::uint32_t block, const SweepRule& rule, int sweeps, float step_s) {
    MELD_EXPECT(block < states_.size() && states_[block].owned && states_[block].active, "block {} of {}", block, states_.size());
    MELD_EXPECT(contacts_.adhesion.empty() || contacts_.adhesion.size() == contacts_.pair_batch_count());
    BodyVelocity* velocities = world_.bodies.velocity.data();
    for (int i = 0; i < sweeps; ++i) {
        if (!turning_.empty()) resist_turning(block, rule, step_s);
        if (contacts_.adhesion.empty())
            sweep(contacts_.plain_pairs(block), velocities, rule);
        else
            sweep_adhesive(contacts_.plain_pairs(block), contacts_.adhesion.data() + contacts_.first_pair_batch(block), step_s, velocities,
                           rule);
        sweep(contacts_.plain_obstacles(block), velocities, rule);
        rows_.sweep(contacts_, block, velocities, step_s, rule);
        shape_contacts_.sweep(block, velocities, rule, step_s);
    }
}

void BlockEngine::find_bounces(const BounceRule& rule, Workers& workers) {
    std::atomic<std::uint8_t> found{0};
    if (find_composite_bounces(rule, workers)) found = std::uint8_t{1 << (kColours - 1)};
    for_blocks(active_, workers, [&](int, std::uint32_t block) {
        const auto colour = static_cast<std::uint8_t>(1u << colour_of(unpack(grid_.blocks()[block].key)));
        if ((found.load(std::memory_order_relaxed) & colour) != 0) return;
        const BodyVelocity* velocities = world_.bodies.velocity.data();
        bool bounces = false;
        look_for_bounces(contacts_.plain_pairs(block), contacts_.pair_bounces(block), velocities, rule, bounces);
        look_for_bounces(contacts_.plain_obstacles(block), contacts_.obstacle_bounces(block), velocities, rule, bounces);
        if (!shape_contacts_.empty()) bounces = bounces || shape_contacts_.any_bounces(world_.bodies, block, rule);
        if (bounces) found.fetch_or(colour, std::memory_order_relaxed);
    });
    bouncing_colours_ = found;
}

void BlockEngine::bounce_block(std::uint32_t block, const BounceRule& rule) {
    BodyVelocity* velocities = world_.bodies.velocity.data();
    bounce(contacts_.plain_pairs(block), contacts_.pair_bounces(block), velocities, rule);
    bounce(contacts_.plain_obstacles(block), contacts_.obstacle_bounces(block), velocities, rule);
    if (!shape_contacts_.empty()) shape_contacts_.bounce(world_.bodies, block, rule);
}

Result<void> BlockEngine::prepare(const StepTimes& times, Workers& workers) {
    // What ended when bodies migrated has been noted.
    if (!cached_) world_.events.clear();
    rebuilt_in_step_ = false;
    substep_ = 0;
    rows_.forget_velocities();
    count_still_ticks(times.dt_s);
    if (divided())
        recomposed_in_step_ = std::exchange(recomposed_before_, false);
    else if ((recomposed_in_step_ = world_.composites.settle(world_.bodies, world_.shapes))) {
        world_.composites.set_all_velocities(world_.bodies, workers);
        world_.joints.recomposed();
        rebuild_ = true;
    }
    place_obstacles(times, 0);
    if (rebuild_ || list_is_old(times))
        if (auto built = rebuild(times, workers); !built) return built;
    prescribe_velocities(times, workers);
    move_all_obstacle_lanes(workers);
    keep_last_good(workers);
    world_.composites.keep();
    begin_loads();
    keep_pushed_awake(times);
    return {};
}

Result<void> BlockEngine::settle(const StepTimes& times, Workers& workers) {
    hear_rests();
    update_sleep();
    world_.obstacles.prepare(workers.threads());
    lay_out_turning_friction(workers);
    if (world_.bounces()) {
        contacts_.begin_bounces({grid_, world_.bodies, world_.obstacles, world_.materials, {.apart_m = list_reach_m()}});
        shape_contacts_.begin_bounces();
    }
    if (!fresh_) {
        // The list is new. Blocks that sleep may wake before the next one, and need its gaps and normals then.
        std::vector<std::uint32_t> all(states_.size());
        std::iota(all.begin(), all.end(), 0u);
        if (auto refreshed = refresh(all, times, workers, After::List); !refreshed) return refreshed;
    }
    // After a failed step all impulses must be forgotten; a step of another length would need impulses of another size.
    if (std::exchange(forget_, false) || (last_substep_s_ != 0 && last_substep_s_ != times.substep_s())) {
        contacts_.forget(workers);
        shape_contacts_.forget_impulses();
        world_.joints.forget_impulses();
    }
    for (const std::uint32_t block : awake_) states_[block].speed_squared = 0;
    return {};
}

double BlockEngine::reach_m() const { return std::max(kLookAheadShare * 2 * smallest_radius_m_, world_.feature_range_m()); }

// Old when the movement so far and in this step could bring together two bodies that the list does not hold.
bool BlockEngine::list_is_old(const StepTimes& times) const {
    if (reach_m() > margin_m_) return true;
    for (std::uint32_t b = 0; b < states_.size(); ++b) {
        const BlockState& state = states_[b];
        const double way_m =
            std::sqrt(static_cast<double>(state.drift_squared)) + std::sqrt(static_cast<double>(state.speed_squared)) * times.dt_s;
        if (way_m > skin_m_ / 2 && (paths_.empty() || std::isinf(state.speed_squared) || leaves_path(b, times.dt_s))) return true;
    }
    return has_obstacle_left_list();
}

bool BlockEngine::leaves_path(std::uint32_t index, double dt_s) const {
    const Block& block = grid_.blocks()[index];
    const std::span<const Path> paths = paths_of(index);
    auto path = paths.begin();
    for (std::uint32_t slot = block.first; slot < block.first + block.count; ++slot) {
        const Drift& drift = world_.bodies.drift[slot];
        const double way_m =
            static_cast<double>(std::hypot(drift.x, drift.y, drift.z)) + length(velocity_of(world_.bodies.velocity[slot])) * dt_s;
        const bool fast = path != paths.end() && path->slot == slot;
        if (way_m > skin_m_ / 2 + (fast ? static_cast<double>(path->length_m) : 0)) return true;
        if (fast) ++path;
    }
    return false;
}

RadiusRange BlockEngine::radii_of_world() const {
    const Settings& settings = world_.settings;
    if (settings.min_radius_m > 0 && settings.max_radius_m > 0) return {settings.min_radius_m, settings.max_radius_m};
    return radius_range(world_.bodies);
}

double BlockEngine::least_radius_m(const RadiusRange& radii) const {
    return world_.shapes.empty() && world_.settings.least_radius_m == 0 ? radii.min : world_.least_radius_m();
}

GridShape BlockEngine::next_shape() const {
    const RadiusRange radii = radii_of_world();
    const double smallest_m = 2 * least_radius_m(radii);
    const double skin = world_.settings.skin_share * smallest_m, margin = std::max(kLookAheadShare * smallest_m, world_.feature_range_m());
    return GridShape::fitting(radii.min, radii.max, margin + skin, 2 * farthest_path_m_);
}

void BlockEngine::set_velocities(const Velocities& all, const StepTimes& times) {
    follows_paths_ = !world_.shapes.empty() && follow_paths(all, times);
    if (!follows_paths_) frame_m_s_ = all.mean(), ahead_s_ = ahead_of_fast_s(times);
    // A faster body ends the step with an error.
    farthest_path_m_ = std::min(all.greatest_beside(frame_m_s_), world_.settings.max_speed_m_s) * ahead_s_;
}

// Lists of shapes take long to make. What bodies have moved since is counted without a frame.
bool BlockEngine::follow_paths(const Velocities& all, const StepTimes& times) {
    const double smallest_m = 2 * world_.least_radius_m(), half_skin_m = world_.settings.skin_share * smallest_m / 2;
    const double greatest_m_s = std::min(all.greatest_beside({}), world_.settings.max_speed_m_s);
    frame_m_s_ = {};
    ahead_s_ = std::min(kStepsOfList * times.dt_s, greatest_m_s > 0 ? smallest_m / greatest_m_s : 0);
    return ahead_s_ > ahead_of_fast_s(times) && greatest_m_s * ahead_s_ > half_skin_m &&
           all.share_above(half_skin_m / ahead_s_) < kFewShare;
}

std::span<const BlockEngine::Path> BlockEngine::paths_of(std::uint32_t index) const {
    const Block& block = grid_.blocks()[index];
    const auto first = std::ranges::lower_bound(paths_, block.first, {}, &Path::slot);
    return {first, std::ranges::lower_bound(first, paths_.end(), block.first + block.count, {}, &Path::slot)};
}

// Of bodies that are fast (PairSearch::Reach), and that the list lets go so far.
void BlockEngine::list_paths() {
    paths_.clear();
    if (!follows_paths_) return;
    const Bodies& bodies = world_.bodies;
    for (std::uint32_t slot = 0; slot < bodies.count(); ++slot)
        if (const double path_m = ahead_s_ * length(velocity_of(bodies.velocity[slot])); path_m > skin_m_ / 2)
            paths_.push_back({slot, static_cast<float>(path_m)});
}

Result<void> BlockEngine::rebuild(const StepTimes& times, Workers& workers) {
    Bodies& bodies = world_.bodies;
    note_stillness();
    const RadiusRange radii = radii_of_world();
    if (world_.has_features()) bodies.need_features();
    smallest_radius_m_ = least_radius_m(radii);
    skin_m_ = world_.settings.skin_share * 2 * smallest_radius_m_;
    margin_m_ = reach_m();
    if (!owns_) set_velocities(velocities_of(bodies), times);
    if (!std::exchange(cached_, false)) cache_contacts(workers);
    Buffer<std::uint32_t> order;
    {
        const StageClock clock(world_.times.sort);
        if (auto built = grid_.build(bodies, next_shape(), list_reach_m(), workers, order); !built)
            return world_.wrong(built.error().problem, built.error().suggestion);
        release_memory(order);
        world_.composites.locate(bodies);
        if (auto settled = world_.joints.settle(world_.movers()); !settled)
            return world_.wrong(settled.error().problem, settled.error().suggestion);
    }
    {
        const StageClock clock(world_.times.pairs);
        std::vector<bool> owned;
        for (const Block& block : grid_.blocks())
            if (owns_) owned.push_back(owns_(unpack(block.key)));
        PairSearch::Reach reach{.apart_m = list_reach_m(), .ahead_s = ahead_s_, .frame_m_s = frame_m_s_};
        reach.slow_m = follows_paths_ ? skin_m_ / 2 : kSlowShare * 2 * smallest_radius_m_;
        if (farthest_path_m_ <= reach.slow_m) reach.ahead_s = 0;
        list_paths();
        const double ahead_s = std::max(kStepsAhead * times.dt_s, ahead_s_);
        begin_list_of_obstacles(kStepsAhead * times.dt_s);
        contacts_.lay_out({grid_, bodies, world_.obstacles, world_.materials, reach, ahead_s, &world_.composites, !world_.shapes.empty()},
                          owns_ ? &owned : nullptr, workers);
        lay_out_shapes(reach, ahead_s, owns_ ? &owned : nullptr, workers);
        lay_out_obstacle_lanes();
        rows_.lay_out(contacts_, shape_contacts_, grid_.blocks().size(), bodies, world_.composites, workers);
        turning_.forget();
        link_blocks();
        grid_.forget_cells();
        states_.assign(grid_.blocks().size(), {});
        cages_.clear();
        for (std::size_t b = 0; b < owned.size(); ++b) states_[b].owned = owned[b];
    }
    for (std::size_t b = 0; b < states_.size(); ++b) {
        const Block& block = grid_.blocks()[b];
        std::uint16_t still = std::numeric_limits<std::uint16_t>::max();
        for (std::uint32_t slot = block.first; slot < block.first + block.count; ++slot) {
            still = std::min(still, bodies.properties[slot].still_ticks);
            bodies.drift[slot] = {0, 0, 0};
        }
        resume_stillness(states_[b], still);
    }
    MELD_ENSURE(states_.size() == grid_.blocks().size());
    MELD_ENSURE(bodies.velocity.size() >= bodies.count() + states_.size(), "{} bodies, {} blocks", bodies.count(), states_.size());
    rebuild_ = fresh_ = load_contacts_fresh_ = false;
    rebuilt_in_step_ = true;
    return {};
}

void BlockEngine::cache_contacts(Workers& workers) {
    for (const CachedContact& gone : contacts_.take_out(world_.bodies, world_.composites, workers))
        world_.events.push_back({touch_of(gone.id(), gone.partner), false});
    for (const ShapeContacts::Ended& gone : shape_contacts_.take_out(world_.bodies, world_.composites))
        world_.events.push_back({gone.is_obstacle ? Touch(gone.body, gone.other, true) : touch_of(gone.body, gone.other), false});
}

void BlockEngine::keep_last_good(Workers& workers) {
    const Bodies& bodies = world_.bodies;
    LastGood& kept = world_.last_good;
    const bool all = world_.settings.keep_last_good;
    const std::size_t count = bodies.count();
    const bool velocities = all || world_.settings.keep_former_velocities;
    kept.velocity.resize(velocities ? count : 0), kept.place.resize(all ? count : 0), kept.orientation.resize(all ? count : 0);
    kept.complete = all;
    if (!velocities) return;
    workers.run((count + kSlotsPerJob - 1) / kSlotsPerJob, [&](int, std::size_t job) {
        const std::size_t begin = job * kSlotsPerJob, length = std::min(count - begin, kSlotsPerJob);
        std::copy_n(bodies.velocity.begin() + static_cast<std::ptrdiff_t>(begin), length,
                    kept.velocity.begin() + static_cast<std::ptrdiff_t>(begin));
        if (!all) return;
        std::copy_n(bodies.place.begin() + static_cast<std::ptrdiff_t>(begin), length,
                    kept.place.begin() + static_cast<std::ptrdiff_t>(begin));
        std::copy_n(bodies.orientation.begin() + static_cast<std::ptrdiff_t>(begin), length,
                    kept.orientation.begin() + static_cast<std::ptrdiff_t>(begin));
    });
}

Result<void> BlockEngine::move(const StepTimes& times, Workers& workers) {
    const StageClock clock(world_.times.move);
    const float limit = squared(world_.settings.max_speed_m_s);
    std::atomic<bool> fine{true};
    rows_.collect(world_.bodies, world_.composites, workers);
    world_.composites.move(world_.bodies, times.substep_s(), workers);
    for_blocks(awake_, workers, [&](int, std::uint32_t block) {
        BlockState& state = states_[block];
        const auto step_s = static_cast<float>(times.substep_s());
        const Moved moved = world_.shapes.empty()
                                ? move_bodies(world_.bodies, grid_.blocks()[block].first, grid_.blocks()[block].count, step_s)
                                : move_shaped(block, step_s);
        state.speed_squared = std::max(state.speed_squared, moved.speed_squared);
        state.drift_squared = moved.drift_squared;
        if (!(moved.speed_squared <= limit)) fine = false;
    });
    prescribe_places(times);
    world_.composites.place_members(world_.bodies, workers);
    ++substep_;
    prescribe_velocities(times, workers);
    place_obstacles(times, substep_);
    if (!world_.shapes.empty() && !world_.composites.all().empty())
        for_blocks(awake_, workers, [&](int, std::uint32_t block) {
            shape_contacts_.turn(shape_setup(), grid_.blocks()[block].first, grid_.blocks()[block].count);
        });
    fresh_ = false;
    return fine ? Result<void>() : world_.check_speeds();
}

Result<void> BlockEngine::refresh(const std::vector<std::uint32_t>& blocks, const StepTimes& times, Workers& workers, After after) {
    const bool goes_on = after == After::Substep;
    const StageClock clock(world_.times.refresh);
    MELD_EXPECT(states_.size() == grid_.blocks().size(), "{} states of {} blocks", states_.size(), grid_.blocks().size());
    const auto max_overlap = static_cast<float>(world_.settings.max_overlap_share);
    if (!goes_on && loads_wanted()) load_contacts_.before_points(shape_contacts_, world_.bodies);
    std::atomic<std::uint32_t> crushed{kNoBlock};
    std::mutex failing;
    std::optional<std::pair<BodyId, Error>> failure;
    const auto fails = [&](const std::pair<BodyId, Error>& wrong) {
        const std::lock_guard lock(failing);
        if (!failure || wrong.first < failure->first) failure = wrong;
    };
    for_blocks(blocks, workers, [&](int worker, std::uint32_t block) {
        if (auto collided = refresh_obstacles(worker, block, times.dt_s); !collided) fails(collided.error());
        const bool moved = after != After::List;
        if (!shape_contacts_.empty() && moved)
            shape_contacts_.follow(block, world_.bodies.velocity.data(), static_cast<float>(times.substep_s()));
        if (!shape_contacts_.empty() && !goes_on)
            if (const auto deep = refresh_shapes(block, times.dt_s, moved)) fails(*deep);
        move_obstacle_lanes(block);
        const bool deep = refresh_pairs(contacts_.pairs(block), world_.bodies.place.data(), max_overlap);
        refresh_fast(block, times.dt_s);
        if (!deep) return;
        std::uint32_t seen = crushed.load();
        while (block < seen && !crushed.compare_exchange_weak(seen, block)) {
        }
    });
    fresh_ = true;
    rows_.places_changed();
    shape_contacts_.places_changed();
    world_.joints.places_changed();
    if (failure) return world_.wrong(failure->second.problem, failure->second.suggestion);
    if (crushed != kNoBlock) return too_deep(crushed);
    return {};
}

void BlockEngine::refresh_fast(std::uint32_t block, double dt_s) {
    const Bodies& bodies = world_.bodies;
    for (const std::uint32_t lane : contacts_.fast_lanes(block)) {
        Batch& batch = contacts_.pairs(block)[lane / kLanes];
        const int i = static_cast<int>(lane % kLanes);
        if (static_cast<double>(batch.gap[i]) <= kLookAheadShare * 2 * smallest_radius_m_) continue;
        const Place &a = bodies.place[batch.a[i]], &b = bodies.place[batch.b[i]];
        const Vec3 path = kStepsAhead * dt_s * (velocity_of(bodies.velocity[batch.b[i]]) - velocity_of(bodies.velocity[batch.a[i]]));
        const auto met = meet({b.x - a.x, b.y - a.y, b.z - a.z}, a.radius + b.radius, path);
        batch.gap[i] = met ? static_cast<float>(met->gap_m) : kNoContactGap;
        if (!met) continue;
        batch.nx[i] = static_cast<float>(met->normal.x);
        batch.ny[i] = static_cast<float>(met->normal.y);
        batch.nz[i] = static_cast<float>(met->normal.z);
    }
}

std::unique_ptr<Engine> make_block_engine(World& world) { return std::make_unique<BlockEngine>(world); }

}  // namespace meld::physics
