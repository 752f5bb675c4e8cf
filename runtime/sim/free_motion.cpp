#include "runtime/sim/free_motion.h"

#include <fmt/format.h>

#include <algorithm>

#include "runtime/base/units.h"

namespace meld::sim {

Result<void> FreeMotion::start(PartState& part) {
    if (!part.alone()) return fail("[motion] kind = \"ode\" runs on one process", "Leave out --parts; --threads uses all cores");
    if (part.next_id > physics::kMostBodies)
        return fail(fmt::format("the world has {} catoms, and the physics moves {} at most", part.next_id, physics::kMostBodies), "Make the body smaller", ExitCode::LimitHit);
    auto made = make_physics_scene(world_);
    if (!made) return tl::unexpected<Error>(made.error());
    physics_ = std::move(*made);
    BodyMaker bodies(world_, physics_);
    for (Catom c = 0; c < part.ensemble.index_count(); ++c) {
        if (!part.owned(c)) continue;
        if (auto added = bodies.add(part.ensemble.id(c), part.start_cells[c], part.ensemble.position(c)); !added)
            return fail(fmt::format("{}: [motion] {}", world_.path, about_catoms(added.error()).problem), added.error().suggestion);
    }
    part.start_cells = {};
    actions_.start(part, world_);
    if (auto started = senses_.start(part, world_); !started) return started;
    bodies_ = awake_ = part.ensemble.owned_count();
    part.moving = true;
    return {};
}

Result<void> FreeMotion::step(PartState& part) {
    if (auto done = actions_.take(part, physics_); !done) return done;
    for (int i = 0; i < world_.physics.steps; ++i)
        if (auto done = step_once(part); !done) return done;
    if (auto done = actions_.release(*physics_.scene); !done) return done;
    part.refresh();
    senses_.sense(part, physics_);
    part.moving = awake_ > 0;
    return {};
}

Result<void> FreeMotion::step_once(PartState& part) {
    // The recording ends with the last tick that went well, whose places the ensemble still has.
    const auto gave_up = [&](const Error& error) {
        const Error told = about_catoms(error);
        return fail(fmt::format("in tick {}, {}", part.abi.now, told.problem), told.suggestion, told.code);
    };
    if (auto done = actions_.push(*physics_.scene, world_.physics.step); !done) return gave_up(done.error());
    const auto report = physics_.scene->step(world_.physics.step, world_.physics.substeps, part.workers);
    if (!report) return gave_up(report.error());
    awake_ = report->awake_bodies;
    links_.update(part, physics_.scene->events());
    senses_.note_obstacles(part, physics_.scene->events());
    return {};
}

void FreeMotion::finish(PartState&) { energy_j_ = physics_.scene ? physics_.scene->kinetic_energy_j() : 0; }

std::string FreeMotion::status() const { return fmt::format("{} of {} bodies awake", format_count(static_cast<double>(awake_)), format_count(static_cast<double>(bodies_))); }

std::string FreeMotion::outcome() const { return fmt::format("{} bodies, {} of them awake, with {:.4g} J of kinetic energy", bodies_, awake_, energy_j_); }

}  // namespace meld::sim
