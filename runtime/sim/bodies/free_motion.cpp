#include "runtime/sim/bodies/free_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/base/process/stage_clock.h"
#include "runtime/base/release_memory.h"
#include "runtime/base/terminal/log.h"
#include "runtime/base/units.h"
#include "runtime/sim/bodies/catom_migration.h"
#include "runtime/sim/bodies/robot_overlaps.h"
#include "runtime/sim/bodies/scripted_motion.h"
#include "runtime/sim/bodies/step_advice.h"
#include "runtime/sim/core/failures/catom_failures.h"
#include "runtime/sim/core/setup/unmatched.h"

namespace meld::sim {

Result<void> FreeMotion::start(Subdomain& subdomain) {
    if (auto fine = check(subdomain); !fine) return fine;
    if (auto done = agree_on_error(subdomain, make_scene(subdomain)); !done) return done;
    if (auto found = look_up(subdomain); !found) return found;
    connections_.sense_all(subdomain, *physics_.scene, senses_);
    if (!subdomain.alone()) divided_.emplace(subdomain, *physics_.scene);
    bodies_ = awake_ = subdomain.ensemble.owned_count();
    subdomain.set_moving(true);
    return {};
}

Result<void> FreeMotion::check(const Subdomain& subdomain) const {
    if (subdomain.next_id() > physics::kMaxBodies)
        return fail(fmt::format("the world has {} catoms, and the physics moves {} at most", subdomain.next_id(), physics::kMaxBodies),
                    "Make the body smaller", ExitCode::LimitHit);
    if (!subdomain.alone() && world_.physics.engine != "blocks")
        return fail(fmt::format("{}: the engine \"{}\" runs on one process", world_.path, world_.physics.engine),
                    "Write [motion] engine = \"blocks\", or leave out -n");
    if (auto fine = joint_changes_.check(subdomain); !fine) return fine;
    return connections_.check(subdomain);
}

Result<void> FreeMotion::look_up(Subdomain& subdomain) {
    actions_.start(subdomain, world_);
    load_senses_.start(subdomain, world_);
    joints_.start(subdomain);
    subdomain.set_homes([this, &subdomain, last = std::pair<physics::Home, world::BrickKey>(), any = false](Catom catom) mutable {
        const physics::Home home = physics_.scene->home(static_cast<physics::BodyId>(subdomain.ensemble.id(catom)));
        // Mostly that of the catom before; the walk along the curve is longer.
        if (!any || last.first != home) last = {home, place_on_curve(physics::unpack(home))}, any = true;
        return last.second;
    });
    if (in_range_) in_range_->senses.start(subdomain);
    if (auto found = range_finders_.start(subdomain); !found) return found;
    if (auto found = light_sensors_.start(subdomain); !found) return found;
    return senses_.start(subdomain, world_);
}

namespace {

void warn_of_empty_groups(Subdomain& subdomain, const std::vector<bool>& met, const std::vector<bool>& movers_met) {
    Unmatched unmatched(subdomain.comm);
    for (std::size_t i = 0; i < movers_met.size(); ++i)
        unmatched.add(movers_met[i], [&mover = subdomain.world.physics.movers[i]] {
            return fmt::format("{}: `{}` matches no catom, so this [[motion.mover]] has no effect", mover.swing.place, mover.where.text());
        });
    for (std::size_t i = 0; i < met.size(); ++i)
        unmatched.add(met[i], [&group = subdomain.world.physics.groups[i]] {
            return fmt::format("{}: `{}` matches no catom, so these [[motion.catoms]] have no effect", group.place, group.where.text());
        });
    unmatched.warn();
}

void warn_of_coarse_steps(Subdomain& subdomain, double least_m, HeightRange heights, const std::set<Surface>& surfaces) {
    if (subdomain.comm.process() != 0 || surfaces.empty()) return;
    const world::PhysicsOptions& options = subdomain.world.physics;
    const bool bounces = std::any_of(surfaces.begin(), surfaces.end(), [](const Surface& s) { return s.restitution > 0; }) ||
                         std::any_of(options.obstacles.begin(), options.obstacles.end(),
                                     [](const world::ObstacleOptions& o) { return o.restitution.value_or(0) > 0; });
    if (const auto advice = advice_on_step(options, greatest_gravity(subdomain.world), 2 * least_m, heights.high - heights.low, bounces))
        log::warning("{}: {}", subdomain.world.path, *advice);
}

}  // namespace

Result<void> FreeMotion::make_scene(Subdomain& subdomain) {
    BodyMaker bodies(world_, subdomain.next_id());
    for (Catom c = 0; c < subdomain.ensemble.index_count(); ++c)
        if (subdomain.owned(c)) bodies.look_at(subdomain.ensemble.id(c), subdomain.start_cell(c), subdomain.ensemble.position(c));
    warn_of_empty_groups(subdomain, bodies.groups_met(), bodies.movers_met());
    ByteWriter bytes;
    if (subdomain.ensemble.owned_count() > 0) {
        bytes.write(bodies.radii());
        bytes.write(bodies.heights());
        bytes.write_count(bodies.moved().size());
        for (const MovedCatom& moved : bodies.moved()) bytes.write(moved);
        for (const Surface& surface : bodies.surfaces()) bytes.write(surface);
    }
    RadiusRange radii;
    HeightRange heights;
    std::set<Surface> surfaces;
    std::vector<MovedCatom> moved;
    for (const auto& from : gather_bytes(subdomain, bytes)) {
        if (from.empty()) continue;
        ByteReader in(from, "radii and surfaces of bodies");
        const auto theirs = in.read<RadiusRange>();
        radii = radii.min > 0 ? both(radii, theirs) : theirs;
        const auto high = in.read<HeightRange>();
        heights = {std::min(heights.low, high.low), std::max(heights.high, high.high)};
        for (auto left = in.read_count(sizeof(MovedCatom)); left > 0; --left) moved.push_back(in.read<MovedCatom>());
        while (!in.done()) surfaces.insert(in.read<Surface>());
    }
    warn_of_coarse_steps(subdomain, radii.least, heights, surfaces);
    const double touch_m = physics::Settings{}.touch_share * 2 * radii.least;
    fixed_touches_ = touches_among(subdomain, bodies.unwatched(), radii.max, touch_m);
    auto made = make_physics_scene(world_, radii, BodySenses::senses_acceleration(subdomain));
    if (!made) return tl::unexpected<Error>(made.error());
    physics_ = std::move(*made);
    if (!subdomain.alone()) physics_.scene->share();
    kinds_ = {radii, surfaces, std::move(moved)};
    Result<void> done = bodies.add_materials(physics_, surfaces);
    physics_.scene->reserve(subdomain.ensemble.owned_count(), subdomain.next_id());
    for (Catom c = 0; done && c < subdomain.ensemble.index_count(); ++c)
        if (subdomain.owned(c))
            done = bodies.make(physics_, subdomain.ensemble.id(c), subdomain.start_cell(c), subdomain.ensemble.position(c));
    if (done) done = add_movers(world_, physics_, kinds_.moved);
    // What follows is done together.
    done = agree_on_error(subdomain, done);
    if (done) done = connections_.connect_groups(subdomain, *physics_.scene, bodies, fixed_touches_);
    if (done) {
        // Errors of joints name their places.
        if (auto joined = joints_.join(subdomain, physics_, bodies, radii.max); !joined) return joined;
        joints_.add_touches(*physics_.scene, fixed_touches_);
        // Until bodies migrate, process 0 has all listed ones.
        if (world_.robots && world_.robots->count() > 0)
            if (auto fine =
                    agree_on_error(subdomain, subdomain.comm.process() == 0 ? check_robots(world_, physics_, bodies) : Result<void>{});
                !fine)
                return fine;
    }
    lamps_.find(subdomain);
    subdomain.forget_start_cells();
    if (!done) return fail(fmt::format("{}: [motion] {}", world_.path, about_catoms(done.error()).problem), done.error().suggestion);
    if (connections_.are_beside_joints(subdomain, *physics_.scene)) physics_.scene->have_all_joined();
    tell_looks(subdomain);
    return {};
}

void FreeMotion::tell_looks(Subdomain& subdomain) {
    const bool joints = world_.physics.has_joints(), forms = world_.physics.has_forms();
    if (joints) subdomain.set_joints([this] { return joints_.looks(*physics_.scene); });
    if (joints || forms) subdomain.set_rounded([this, &subdomain](Catom c) { return rounded_of(subdomain, c); }, forms);
    if (forms) return;
    if (kinds_.radii.min == world_.radius && kinds_.radii.max == world_.radius) return;
    subdomain.set_diameters([this, &subdomain](Catom c) {
        return physics_.scene->radius(static_cast<physics::BodyId>(subdomain.ensemble.id(c))) / world_.radius;
    });
}

world::RoundedBody FreeMotion::rounded_of(const Subdomain& subdomain, Catom catom) const {
    const auto body = static_cast<physics::BodyId>(subdomain.ensemble.id(catom));
    const physics::Scene& scene = *physics_.scene;
    return world::look_of(scene.shape(body).value_or(physics::BodyShape{{}, scene.radius(body)}), scene.state(body).orientation,
                          2 * world_.radius);
}

Result<void> FreeMotion::step(Subdomain& subdomain) {
    MELD_EXPECT(physics_.scene != nullptr && divided_.has_value() == !subdomain.alone());
    if (auto done = actions_.take(subdomain, physics_, divided_ ? &*divided_ : nullptr); !done) return done;
    connect_bodies(subdomain);
    drive_joints(subdomain);
    change_joints(subdomain);
    dim_lamps(subdomain);
    // Of several processes, perhaps not all have a catom with limits.
    if (load_senses_.reads_loads() || (divided_ && connections_.may_break())) physics_.scene->want_loads();
    const auto steps = static_cast<std::uint64_t>(world_.physics.steps), before = static_cast<std::uint64_t>(subdomain.tick() - 1) * steps;
    for (std::uint64_t i = 0; i < steps; ++i) {
        if (changes_gravity(world_))
            if (auto set = physics_.scene->set_gravity(gravity_in_step(world_, before + i)); !set) return set;
        if (auto done = step_once(subdomain); !done) return done;
    }
    if (auto done = actions_.release(*physics_.scene); !done) return done;
    if (auto done = load_connections(subdomain); !done) return done;
    if (auto done = lose_catoms(subdomain); !done) return done;
    subdomain.refresh();
    look_around(subdomain);
    if (in_range_) find_in_range(subdomain);
    const StageClock clock(sensing_s_);
    senses_.sense(subdomain, physics_, divided_ ? &*divided_ : nullptr);
    load_senses_.sense(subdomain, *physics_.scene);
    joints_.sense(subdomain, *physics_.scene);
    if (in_range_) in_range_->senses.sense(subdomain);
    if (range_finders_.active()) range_finders_.sense(subdomain, *physics_.scene, *surroundings_);
    if (light_sensors_.active()) light_sensors_.sense(subdomain, *physics_.scene, *surroundings_, lamps_.shining());
    bodies_ = subdomain.ensemble.owned_count();
    subdomain.set_moving(goes_on());
    subdomain.set_motion_bytes(physics_.scene->bytes());
    return {};
}

// Bodies may sleep while coils warm or cool that a program looks at, or that will be switched off or weaker.
bool FreeMotion::goes_on() const {
    if (awake_ > 0) return true;
    constexpr double kLeast_k = 0.01;
    const bool matters = senses_.senses_temperatures() ||
                         std::ranges::any_of(physics_.features, [](const physics::Feature& feature) { return feature.hottest_k > 0; });
    return matters && physics_.scene->warming(std::max(kLeast_k, world_.physics.sense.temperature));
}

void FreeMotion::connect_bodies(Subdomain& subdomain) {
    const bool asks = subdomain.program_actions.uses(ActionKind::Connect) || subdomain.program_actions.uses(ActionKind::Release);
    if (!actions_.any_wrenches() || !asks) return;
    for (const RefusedConnection& each : connections_.carry_out(subdomain, physics_, senses_, actions_.asked()))
        actions_.report_failed(subdomain, each.catom, each.action, each.why);
}

void FreeMotion::drive_joints(Subdomain& subdomain) {
    const bool together = divided_ && actions_.any_wrenches() && world_.physics.has_joints();
    if (!together && actions_.asked_drives().empty()) return;
    for (const RefusedDrive& each : joints_.carry_out(subdomain, *physics_.scene, actions_.asked_drives(), together ? &*divided_ : nullptr))
        actions_.report_failed(subdomain, each.catom, each.action, each.why);
}

void FreeMotion::dim_lamps(Subdomain& subdomain) {
    if (!actions_.any_wrenches() || !subdomain.program_actions.uses(ActionKind::Lamp)) return;
    for (const Catom catom : lamps_.carry_out(subdomain, actions_.asked_lamps()))
        actions_.report_failed(subdomain, catom, ActionKind::Lamp, Refusal::NoSuchFeature);
}

void FreeMotion::change_joints(Subdomain& subdomain) {
    if (!actions_.any_wrenches() || !JointChanges::asks(subdomain)) return;
    std::vector<RefusedJoint> refused;
    ChangedJoints changed = joint_changes_.carry_out(subdomain, physics_, links_, actions_.asked_joints(), refused);
    for (const RefusedJoint& each : refused) actions_.report_failed(subdomain, each.catom, each.action, each.why);
    // Before the first step nobody is a neighbour yet, and fixed touches have those of joints once.
    std::erase_if(changed.ended, [&](const physics::ConnectionPair& pair) {
        const auto found = std::ranges::find(fixed_touches_, physics::Touch(pair.first, pair.second, false), &physics::TouchEvent::touch);
        if (found == fixed_touches_.end()) return false;
        fixed_touches_.erase(found);
        return true;
    });
    connections_.change_joints(physics_, changed);
}

void FreeMotion::part_broken(Subdomain& subdomain) {
    const auto ours = physics_.scene->broken_joints();
    std::vector<physics::ConnectionPair> broken(ours.begin(), ours.end());
    if (divided_ && joints_.may_break()) broken = gather_pairs(subdomain, broken);
    if (broken.empty()) return;
    load_senses_.note_broken(subdomain, broken);
    connections_.part(broken);
    broken_joints_ += broken.size();
}

Result<void> FreeMotion::load_connections(Subdomain& subdomain) {
    physics::Scene& scene = *physics_.scene;
    auto solved = scene.solve_loads(subdomain.workers);
    Result<void> fine;
    if (!solved) {
        const Error error = about_catoms(solved.error());
        fine = fail(fmt::format("in tick {}, {}", subdomain.tick(), error.problem), error.suggestion, error.code);
    }
    const bool together = divided_ && scene.connection_count() > 0 && (load_senses_.reads_loads() || connections_.may_break());
    if (together) fine = agree_on_error(subdomain, fine);
    if (!fine) return fine;
    std::vector<physics::ConnectionPair> broken = std::move(*solved);
    if (together && connections_.may_break()) {
        broken = gather_pairs(subdomain, broken);
        for (const auto& [one, other] : broken)
            if (auto done = scene.release(one, other); !done) return done;
    }
    for (const auto& [one, other] : broken) senses_.note_connection(subdomain, one, other, false);
    load_senses_.note_broken(subdomain, broken);
    broken_count_ += broken.size();
    return {};
}

void FreeMotion::look_around(Subdomain& subdomain) {
    const bool sight = in_range_ && in_range_->sight;
    if (!sight && !range_finders_.active() && !light_sensors_.active()) return;
    const StageClock clock(sensing_s_);
    if (!surroundings_) surroundings_.emplace(kinds_.radii.min, kinds_.radii.max);
    const double sight_m = sight ? world_.links->range * 2 * world_.radius : 0;
    const double range_m = range_finders_.active() ? range_finders_.greatest_reach_m() + kinds_.radii.max : 0;
    std::vector<BodySurroundings::FarPlace> lamps;
    if (light_sensors_.active()) {
        lamps_.place(subdomain, *physics_.scene);
        for (const Shining& lamp : lamps_.shining()) lamps.push_back({lamp.place_m, lamp.reach_m});
    }
    surroundings_->gather(subdomain, *physics_.scene, std::max(sight_m, range_m), lamps);
}

void FreeMotion::find_in_range(Subdomain& subdomain) {
    const StageClock clock(linking_s_);
    for (Catom c = 0; c < subdomain.ensemble.index_count(); ++c) {
        if (!subdomain.owned(c)) continue;
        const auto body = static_cast<physics::BodyId>(subdomain.ensemble.id(c));
        if (subdomain.place(c, to_diameters(world_, physics_.scene->state(body).position_m))) subdomain.mark(c, kDirtyPlace);
    }
    if (in_range_->sight)
        in_range_->links.update(subdomain, [this](u64 one, u64 other) { return surroundings_->sees(*physics_.scene, one, other); });
    else
        in_range_->links.update(subdomain);
    in_range_->seen = subdomain.ensemble.links().version();
    subdomain.refresh();
}

// Catoms that an event has killed.
void FreeMotion::struck(Subdomain& subdomain) {
    if (!in_range_) return;
    const std::uint64_t now = subdomain.ensemble.links().version();
    if (std::exchange(in_range_->seen, now) == now) return;
    subdomain.refresh();
    in_range_->senses.sense(subdomain);
}

Result<void> FreeMotion::step_once(Subdomain& subdomain) {
    const auto report = move(subdomain);
    // The ensemble still has the positions of the last good tick.
    if (!report) {
        const Error error = about_catoms(report.error());
        return fail(fmt::format("in tick {}, {}", subdomain.tick(), error.problem), error.suggestion, error.code);
    }
    awake_ = report->awake_bodies;
    const auto touches = divided_ ? connections_.follow_together(subdomain, *physics_.scene, events(), report->recomposed)
                                  : connections_.follow(*physics_.scene, events(), report->recomposed);
    note_fixed_touches(subdomain, touches);
    const StageClock clock(linking_s_);
    const DividedBodies* divided = divided_ ? &*divided_ : nullptr;
    senses_.note_obstacles(subdomain, touches);
    if (!in_range_)
        links_.note(subdomain, fixed_touches_.empty() ? touches : std::span<const physics::TouchEvent>(fixed_touches_),
                    connections_.parted(), divided);
    release_memory(fixed_touches_);
    lost_.clear();
    part_broken(subdomain);
    physics_.scene->forget_events();
    if (!in_range_) links_.connect(subdomain, divided);
    return {};
}

void FreeMotion::note_fixed_touches(Subdomain& subdomain, std::span<const physics::TouchEvent> events) {
    if (fixed_touches_.empty()) return;
    // All processes know all of them; the owner of the first reports it.
    std::erase_if(fixed_touches_, [&](const physics::TouchEvent& e) {
        return !physics_.scene->has(e.touch.body) || (divided_ && divided_->owner_of(e.touch.body) != subdomain.comm.process());
    });
    if (physics_.scene->connection_count() > 0) connections_.adopt(subdomain, *physics_.scene, fixed_touches_);
    fixed_touches_.insert(fixed_touches_.end(), events.begin(), events.end());
    std::sort(fixed_touches_.begin(), fixed_touches_.end());
}

// Their links ended when they were lost.
std::span<const physics::TouchEvent> FreeMotion::events() {
    const auto all = physics_.scene->events();
    if (lost_.empty()) return all;
    const auto is_lost = [&](physics::BodyId id) { return std::binary_search(lost_.begin(), lost_.end(), id); };
    events_.clear();
    std::copy_if(all.begin(), all.end(), std::back_inserter(events_), [&](const physics::TouchEvent& e) {
        return !is_lost(e.touch.body) && (e.touch.other_is_obstacle || !is_lost(e.touch.other));
    });
    return events_;
}

Result<void> FreeMotion::lose_catoms(Subdomain& subdomain) {
    const std::optional<double>& lowest = world_.physics.lowest;
    if (!lowest) return {};
    physics::Scene& scene = *physics_.scene;
    ByteWriter mine;
    for (Catom c = 0; c < subdomain.ensemble.index_count(); ++c) {
        if (!subdomain.owned(c)) continue;
        const auto id = static_cast<physics::BodyId>(subdomain.ensemble.id(c));
        if (height_of(world_, scene.state(id).position_m) < *lowest * 2 * world_.radius) mine.write(id);
    }
    std::vector<physics::BodyId> lost;
    for (const auto& from : gather_bytes(subdomain, mine))
        for (ByteReader in(from, "catoms that are lost"); !in.done();) lost.push_back(in.read<physics::BodyId>());
    if (lost.empty()) return {};
    std::sort(lost.begin(), lost.end());
    if (world_.physics.lost == "stop")
        return fail(fmt::format("in tick {}, catom @{} is below [motion] lowest = {:.6g}", subdomain.tick(), lost[0], *lowest),
                    "Put ground under it, or write lost = \"remove\" to go on without it", ExitCode::LimitHit);
    lost_count_ += lost.size();
    return take_out_all(subdomain, std::move(lost));
}

Result<void> FreeMotion::lose(Subdomain& subdomain, std::span<const Killed> killed) {
    std::vector<physics::BodyId> ids;
    for (const Killed& each : killed) ids.push_back(static_cast<physics::BodyId>(each.id));
    // What rested on them falls.
    subdomain.set_moving(true);
    return take_out_all(subdomain, std::move(ids));
}

Result<void> FreeMotion::take_out_all(Subdomain& subdomain, std::vector<physics::BodyId> ids) {
    MELD_EXPECT(std::is_sorted(ids.begin(), ids.end()), "{} bodies are not in order", ids.size());
    physics::Scene& scene = *physics_.scene;
    connections_.lose(subdomain, scene, senses_, ids);
    load_senses_.lose(subdomain, scene, ids);
    joints_.lose(subdomain, scene, ids);
    lamps_.lose(ids);
    for (const physics::BodyId id : ids) {
        // The next step drops the body on all processes that hold it.
        if (scene.has(id)) {
            if (auto removed = scene.remove_body(id); !removed) return removed;
        } else {
            scene.release_all(id);
        }
        if (const std::optional<Catom> catom = subdomain.ensemble.find(id)) take_out(subdomain, *catom);
    }
    links_.forget(ids);
    const auto middle = static_cast<std::ptrdiff_t>(lost_.size());
    lost_.insert(lost_.end(), ids.begin(), ids.end());
    std::inplace_merge(lost_.begin(), lost_.begin() + middle, lost_.end());
    return {};
}

Result<physics::StepReport> FreeMotion::move(Subdomain& subdomain) {
    const double step_s = world_.physics.step;
    const int substeps = world_.physics.substeps;
    if (actions_.any_wrenches())
        if (auto applied = agree_on_error(subdomain, actions_.apply(*physics_.scene, step_s)); !applied)
            return tl::unexpected<Error>(applied.error());
    if (!divided_) return physics_.scene->step(step_s, substeps, subdomain.workers);
    const auto changed_hands = hand_over(subdomain, step_s, substeps);
    if (!changed_hands) return tl::unexpected<Error>(changed_hands.error());
    moved_ = true;
    auto report = divided_->step(subdomain, step_s, substeps);
    if (report && *changed_hands && actions_.any_wrenches()) actions_.follow(subdomain, *divided_);
    return report;
}

Result<bool> FreeMotion::hand_over(Subdomain& subdomain, double step_s, int substeps) {
    const StageClock clock(handing_over_s_);
    auto changed_hands = divided_->redistribute(subdomain, step_s, substeps);
    if (!changed_hands || !*changed_hands) return changed_hands;
    migrate_catoms(subdomain, *divided_, links_);
    if (moved_) crossed_ += divided_->departed().size();
    return changed_hands;
}

void FreeMotion::finish(Subdomain& subdomain) {
    if (!physics_.scene) return;
    ByteWriter mine;
    mine.write(bodies_);
    mine.write(awake_);
    mine.write(crossed_);
    mine.write(physics_.scene->kinetic_energy_j());
    mine.write(std::uint64_t{physics_.scene->joint_count()});
    bodies_ = awake_ = crossed_ = joined_ = 0;
    connected_ = physics_.scene->connection_count();
    energy_j_ = 0;
    for (const auto& from : gather_bytes(subdomain, mine)) {
        ByteReader in(from, "counts of bodies");
        bodies_ += in.read<std::uint64_t>();
        awake_ += in.read<std::uint64_t>();
        crossed_ += in.read<std::uint64_t>();
        energy_j_ += in.read<double>();
        joined_ += in.read<std::uint64_t>();
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
    if (connected_ > 0) text += fmt::format("; {} connection{}", connected_, connected_ == 1 ? "" : "s");
    if (joined_ > 0) text += fmt::format("; {} joint{}", joined_, joined_ == 1 ? "" : "s");
    const auto tell_broken = [&](std::uint64_t count, std::string_view what) {
        if (count > 0) text += fmt::format("; {} {}{} broke", count, what, count == 1 ? "" : "s");
    };
    tell_broken(broken_joints_, "joint"), tell_broken(broken_count_, "connection");
    if (lost_count_ > 0) text += fmt::format("; {} below the lowest height removed", lost_count_);
    if (crossed_ > 0) text += fmt::format("; {} migrations of catoms between processes", crossed_);
    if (divided_ && divided_->divisions() > 0)
        text += fmt::format("; {} times space was divided again, and no process had more than {:.2f} of the mean", divided_->divisions(),
                            divided_->greatest_load());
    return text;
}

}  // namespace meld::sim
