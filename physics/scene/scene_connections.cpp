// Rigid connections between the bodies of a scene.
#include <fmt/format.h>

#include "physics/scene/scene.h"
#include "physics/solver/engine.h"

namespace meld::physics {

namespace {

const char* name_of(EngineKind engine) {
    switch (engine) {
        case EngineKind::Blocks:
            return "Blocks";
        case EngineKind::Hash:
            return "Hash";
        case EngineKind::Ode:
            return "Ode";
    }
    return "?";
}

}  // namespace

Result<void> Scene::connect(BodyId body, BodyId other) {
    for (const BodyId one : {body, other})
        if (auto fine = known(one); !shared_ && !fine) return fine;
    if (body == other) return fail(fmt::format("body {} cannot be connected to itself", body), "Name another body");
    if (world_->settings.engine != EngineKind::Blocks)
        return fail(fmt::format("bodies {} and {} cannot be connected (the engine {} has no composites)", body, other,
                                name_of(world_->settings.engine)),
                    "Use the engine Blocks");
    if (engine_->divided() && !shared_)
        return fail(fmt::format("bodies {} and {} cannot be connected (the world is divided)", body, other), "Share the scene before");
    if (connected(body, other)) return {};
    world_->composites.connect(body, other);
    for (const BodyId one : {body, other})
        if (has(one)) engine_->body_changed(world_->bodies.slot(one), false);
    return {};
}

Result<void> Scene::release(BodyId body, BodyId other) {
    for (const BodyId one : {body, other})
        if (auto fine = known(one); !shared_ && !fine) return fine;
    if (!connected(body, other)) return {};
    world_->composites.release(body, other);
    for (const BodyId one : {body, other})
        if (has(one)) engine_->body_changed(world_->bodies.slot(one), false);
    return {};
}

void Scene::release_all(BodyId body) { world_->composites.release_all(body); }

bool Scene::together(BodyId body, BodyId other) const { return world_->composites.connections().together(body, other); }

bool Scene::connected(BodyId body, BodyId other) const { return world_->composites.connections().connected(body, other); }

std::span<const BodyId> Scene::connected_to(BodyId body) const { return world_->composites.connections().neighbours(body); }

std::size_t Scene::connection_count() const { return world_->composites.connections().count(); }

std::vector<std::pair<BodyId, BodyId>> Scene::connections() const { return world_->composites.connections().all(); }

bool Scene::lasts(const Touch& touch) const {
    const Composites& composites = world_->composites;
    const auto stands = [&](BodyId body) {
        if (const std::uint32_t index = composites.composite_of(body); index != kNoComposite) {
            const Composite& composite = composites.all()[index];
            return composite.carried() && composite.motion.velocity_m_s == Vec3{} && composite.motion.spin_rad_s == Vec3{};
        }
        if (!has(body)) return false;
        const std::uint32_t slot = world_->bodies.slot(body);
        return (world_->bodies.properties[slot].flags & kFixed) != 0 && velocity_of(world_->bodies.velocity[slot]) == Vec3{};
    };
    if (touch.other_is_obstacle) return composites.composite_of(touch.body) != kNoComposite && stands(touch.body);
    const std::uint32_t one = composites.composite_of(touch.body);
    if (one != kNoComposite && one == composites.composite_of(touch.other)) return true;
    return stands(touch.body) && stands(touch.other);
}

void Scene::want_loads() { world_->loads.want(); }

Result<void> Scene::set_breaking(BodyId body, const BreakingLimits& limits) {
    if (auto fine = known(body); !fine) return fine;
    for (const double limit : {limits.force_n, limits.torque_nm})
        if (!(limit > 0))
            return fail(fmt::format("the connections of body {} break at a load of {} (which is not above 0)", body, limit),
                        "Give a positive limit, or infinity");
    world_->loads.set_limits(body, limits);
    return {};
}

Result<std::vector<ConnectionPair>> Scene::solve_loads(Workers& workers) {
    world_->joints.take_loads();
    if (!world_->loads.wanted()) {
        world_->loads.forget();
        return std::vector<ConnectionPair>();
    }
    auto broken = world_->loads.solve(world_->composites, world_->bodies, world_->shapes, workers);
    if (!broken) return world_->wrong(broken.error().problem, broken.error().suggestion);
    for (const auto& [one, other] : *broken)
        if (auto done = release(one, other); !done) return tl::unexpected(done.error());
    return broken;
}

std::optional<ConnectionLoad> Scene::load(BodyId body, BodyId other) const { return world_->loads.of(body, other); }

std::span<const CarriedLoad> Scene::loads() const { return world_->loads.all(); }

std::optional<CompositeState> Scene::composite(BodyId body) const {
    const Composites& composites = world_->composites;
    const std::uint32_t index = composites.composite_of(body);
    if (index == kNoComposite) return std::nullopt;
    const Composite& composite = composites.all()[index];
    return CompositeState{.bodies = composite.count,
                          .mass_kg = composite.mass_kg,
                          .centre_m = composite.motion.centre_m,
                          .linear_velocity_m_s = composite.motion.velocity_m_s,
                          .angular_velocity_rad_s = composite.motion.spin_rad_s,
                          .inertia_kg_m2 = turned(composite.inertia, composite.motion.turn),
                          .carried = composite.carried()};
}

}  // namespace meld::physics
