#include "runtime/sim/bodies/free_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/base/give_back.h"
#include "runtime/base/log.h"
#include "runtime/base/stage_clock.h"
#include "runtime/base/units.h"
#include "runtime/sim/bodies/catom_migration.h"

namespace meld::sim {

Result<void> FreeMotion::start(Subdomain& part) {
    if (part.next_id() > physics::kMaxBodies)
        return fail(fmt::format("the world has {} catoms, and the physics moves {} at most", part.next_id(), physics::kMaxBodies),
                    "Make the body smaller", ExitCode::LimitHit);
    if (!part.alone() && world_.physics.engine != "blocks")
        return fail(fmt::format("{}: the engine \"{}\" runs on one process", world_.path, world_.physics.engine),
                    "Write [motion] engine = \"blocks\", or leave out -n");
    if (auto done = agree_on_error(part, make_scene(part)); !done) return done;
    actions_.start(part, world_);
    if (auto started = senses_.start(part, world_); !started) return started;
    if (!part.alone()) divided_.emplace(part, *physics_.scene);
    bodies_ = awake_ = part.ensemble.owned_count();
    part.set_moving(true);
    return {};
}

namespace {

// A region that matches no catom on any part is hardly meant.
void warn_of_empty_groups(Subdomain& part, std::vector<bool> met) {
    ByteWriter mine;
    for (const bool some : met) mine.write(some);
    for (const auto& theirs : gather_bytes(part, mine))
        for (std::size_t i = 0; i < met.size(); ++i) met[i] = met[i] || theirs[i] != std::byte{0};
    if (part.comm.part() != 0) return;
    for (std::size_t i = 0; i < met.size(); ++i)
        if (const world::CatomGroup& group = part.world.physics.groups[i]; !met[i])
            log::warning("{}: `{}` matches no catom, so these [[motion.catoms]] are of none", group.place, group.where.text());
}

}  // namespace

Result<void> FreeMotion::make_scene(Subdomain& part) {
    BodyMaker bodies(world_, part.next_id());
    for (Catom c = 0; c < part.ensemble.index_count(); ++c)
        if (part.owned(c)) bodies.look_at(part.ensemble.id(c), part.start_cell(c), part.ensemble.position(c));
    warn_of_empty_groups(part, bodies.groups_met());
    ByteWriter bytes;
    if (part.ensemble.owned_count() > 0) {
        bytes.write(bodies.radii());
        for (const Surface& surface : bodies.surfaces()) bytes.write(surface);
    }
    RadiusRange radii;
    std::set<Surface> surfaces;
    for (const auto& from : gather_bytes(part, bytes)) {
        if (from.empty()) continue;
        ByteReader in(from, "radii and surfaces of bodies");
        const auto theirs = in.read<RadiusRange>();
        radii = {radii.min > 0 ? std::min(radii.min, theirs.min) : theirs.min, std::max(radii.max, theirs.max)};
        while (!in.done()) surfaces.insert(in.read<Surface>());
    }
    const double touch_m = physics::Settings{}.touch_share * 2 * radii.min;
    fixed_touches_ = touches_among(part, bodies.at_rest(), radii.max, touch_m);
    auto made = make_physics_scene(world_, radii, BodySenses::senses_acceleration(part));
    if (!made) return tl::unexpected<Error>(made.error());
    physics_ = std::move(*made);
    auto done = bodies.add_materials(physics_, surfaces);
    physics_.scene->reserve(part.ensemble.owned_count(), part.next_id());
    for (Catom c = 0; done && c < part.ensemble.index_count(); ++c)
        if (part.owned(c)) done = bodies.make(physics_, part.ensemble.id(c), part.start_cell(c), part.ensemble.position(c));
    part.forget_start_cells();
    if (!done) return fail(fmt::format("{}: [motion] {}", world_.path, about_catoms(done.error()).problem), done.error().suggestion);
    if (radii.min != world_.radius || radii.max != world_.radius)
        part.set_diameters(
            [this, &part](Catom c) { return physics_.scene->radius(static_cast<physics::BodyId>(part.ensemble.id(c))) / world_.radius; });
    return {};
}

Result<void> FreeMotion::step(Subdomain& part) {
    MELD_EXPECT(physics_.scene != nullptr && divided_.has_value() == !part.alone());
    if (auto done = actions_.take(part, physics_, divided_ ? &*divided_ : nullptr); !done) return done;
    for (int i = 0; i < world_.physics.steps; ++i)
        if (auto done = step_once(part); !done) return done;
    if (auto done = actions_.release(*physics_.scene); !done) return done;
    part.refresh();
    const StageClock clock(sensing_s_);
    senses_.sense(part, physics_, divided_ ? &*divided_ : nullptr);
    bodies_ = part.ensemble.owned_count();
    part.set_moving(awake_ > 0);
    part.set_motion_bytes(physics_.scene->bytes());
    return {};
}

Result<void> FreeMotion::step_once(Subdomain& part) {
    const auto report = move(part);
    // The ensemble still has the places of the last tick that went well.
    if (!report) {
        const Error error = about_catoms(report.error());
        return fail(fmt::format("in tick {}, {}", part.tick(), error.problem), error.suggestion, error.code);
    }
    awake_ = report->awake_bodies;
    note_fixed_touches(part);
    const StageClock clock(linking_s_);
    const DividedBodies* divided = divided_ ? &*divided_ : nullptr;
    senses_.note_obstacles(part, physics_.scene->events());
    links_.note(part, fixed_touches_.empty() ? physics_.scene->events() : std::span<const physics::TouchEvent>(fixed_touches_), divided);
    give_back(fixed_touches_);
    physics_.scene->forget_events();
    links_.connect(part, divided);
    return {};
}

void FreeMotion::note_fixed_touches(const Subdomain& part) {
    if (fixed_touches_.empty()) return;
    // All parts know all of them; the owner of the first reports it.
    std::erase_if(fixed_touches_, [&](const physics::TouchEvent& e) {
        return !physics_.scene->has(e.touch.body) || (divided_ && divided_->owner_of(e.touch.body) != part.comm.part());
    });
    const auto events = physics_.scene->events();
    fixed_touches_.insert(fixed_touches_.end(), events.begin(), events.end());
    std::sort(fixed_touches_.begin(), fixed_touches_.end());
}

Result<physics::StepReport> FreeMotion::move(Subdomain& part) {
    const double step_s = world_.physics.step;
    const int substeps = world_.physics.substeps;
    if (actions_.any_wrenches())
        if (auto applied = agree_on_error(part, actions_.apply(*physics_.scene, step_s)); !applied)
            return tl::unexpected<Error>(applied.error());
    if (!divided_) return physics_.scene->step(step_s, substeps, part.workers);
    const auto changed_hands = hand_over(part, step_s, substeps);
    if (!changed_hands) return tl::unexpected<Error>(changed_hands.error());
    moved_ = true;
    auto report = divided_->step(part, step_s, substeps);
    if (report && *changed_hands && actions_.any_wrenches()) actions_.follow(part, *divided_);
    return report;
}

Result<bool> FreeMotion::hand_over(Subdomain& part, double step_s, int substeps) {
    const StageClock clock(handing_over_s_);
    auto changed_hands = divided_->redistribute(part, step_s, substeps);
    if (!changed_hands || !*changed_hands) return changed_hands;
    migrate_catoms(part, *divided_, links_);
    if (moved_) crossed_ += divided_->departed().size();
    return changed_hands;
}

void FreeMotion::finish(Subdomain& part) {
    if (!physics_.scene) return;
    ByteWriter mine;
    mine.write(bodies_);
    mine.write(awake_);
    mine.write(crossed_);
    mine.write(physics_.scene->kinetic_energy_j());
    bodies_ = awake_ = crossed_ = 0;
    energy_j_ = 0;
    for (const auto& from : gather_bytes(part, mine)) {
        ByteReader in(from, "counts of bodies");
        bodies_ += in.read<std::uint64_t>();
        awake_ += in.read<std::uint64_t>();
        crossed_ += in.read<std::uint64_t>();
        energy_j_ += in.read<double>();
    }
}

std::string FreeMotion::status() const {
    return fmt::format("{} of {} bodies awake", format_count(static_cast<double>(awake_)), format_count(static_cast<double>(bodies_)));
}

SimModule::Stages FreeMotion::stages() const {
    if (!physics_.scene) return {};
    const physics::StageTimes t = physics_.scene->stage_times();
    Stages stages = {{"sort", t.sort}, {"pairs", t.pairs},    {"contacts", t.refresh}, {"features", t.actuation}, {"sweeps", t.solve},
                     {"move", t.move}, {"touches", t.events}, {"links", linking_s_},   {"senses", sensing_s_}};
    if (divided_) stages.emplace_back("hand_over", handing_over_s_);
    return stages;
}

std::string FreeMotion::outcome() const {
    std::string text = fmt::format("{} bodies, {} of them awake, with {:.4g} J of kinetic energy", bodies_, awake_, energy_j_);
    if (crossed_ > 0) text += fmt::format("; {} times a catom has come to another process", crossed_);
    if (divided_ && divided_->divisions() > 0)
        text += fmt::format("; {} times space was divided anew, and no process had more than {:.2f} of the mean", divided_->divisions(),
                            divided_->greatest_load());
    return text;
}

}  // namespace meld::sim
