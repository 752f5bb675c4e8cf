#include "runtime/show/picture/stage.h"

#include <algorithm>
#include <limits>

#include "runtime/show/picture/joints.h"
#include "runtime/show/picture/lamps.h"
#include "runtime/show/picture/obstacles.h"
#include "runtime/world/description/compounds.h"

namespace meld::picture {

namespace {

using render::Vec;

constexpr float kAbove = 0.62F;       // In the plane, lines are so much above the middles of catoms.
constexpr float kSmall = 0.5F;        // In space, catoms are so much smaller where there are lines.
constexpr float kTailRadius = 0.22F;  // Of the bar from an amoebot's head to its tail.

render::Rgb rgb(std::uint32_t c) {
    return {static_cast<std::uint8_t>(c >> 16), static_cast<std::uint8_t>(c >> 8), static_cast<std::uint8_t>(c)};
}

// Of a lattice that fills space, from a catom to each of its neighbours.
std::vector<Vec> ways_of(const world::Lattice& lattice) {
    std::vector<Vec> out;
    if (lattice.flat()) return out;
    const world::Cell middle = {0, 0, 0};
    for (int port = 0; port < lattice.ports(); ++port) out.push_back(vec_of(lattice.position(lattice.neighbour(middle, port))));
    return out;
}

}  // namespace

Vec vec_of(const world::Vec3& at) { return {static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2])}; }

render::RoundedBody rounded_of(const world::RoundedBody& body) {
    const auto [w, x, y, z] = body.turn;
    const Eigen::Quaternionf turn = Eigen::Quaterniond(w, x, y, z).normalized().cast<float>();
    if (const auto compound = body.compound()) return {Vec::Zero(), static_cast<float>(body.core[0]), turn, compound};
    return {vec_of(body.core), static_cast<float>(body.rounding), turn};
}

std::vector<std::vector<render::CompoundSolid>> compounds_of(const world::World& world) {
    std::vector<std::vector<render::CompoundSolid>> out;
    for (const physics::BodyShape& shape : world::compounds_of(world.physics, 1)) {
        std::vector<render::CompoundSolid>& solids = out.emplace_back();
        for (const physics::ShapePart& part : shape.parts)
            solids.push_back(
                {vec_of({part.at_m.x, part.at_m.y, part.at_m.z}), rounded_of(world::look_of(physics::solid_of(part), part.turn, 1))});
    }
    return out;
}

Stage::Stage(const record::Drawn& drawn, const world::World& world, bool free, std::int64_t tick, const Look& look)
    : drawn_(drawn), world_(world), look_(look), in_plane_(!free && world::Lattice(world.lattice).flat()) {
    frame.tick = tick;
    frame.catoms = drawn.ids.size();
    frame.scene.form = look.form.value_or(free ? render::Form::Sphere : form_of(world.lattice));
    frame.scene.compounds = compounds_of(world);
    if (!free) frame.scene.ways = ways_of(world::Lattice(world.lattice));
}

void Stage::show(const std::vector<bool>& shown) {
    render::Scene& scene = frame.scene;
    places_.assign(drawn_.ids.size(), -1);
    for (std::size_t i = 0; i < drawn_.ids.size(); ++i) {
        if (!shown[i]) continue;
        places_[i] = static_cast<std::ptrdiff_t>(scene.places.size());
        scene.places.push_back(vec_of(drawn_.positions[i]));
        frame.ids.push_back(drawn_.ids[i]);
        scene.colours.push_back(rgb(drawn_.colours[i]));
        if (!drawn_.diameters.empty()) scene.diameters.push_back(static_cast<float>(drawn_.diameters[i]));
        if (drawn_.rounded.empty()) continue;
        render::RoundedBody body = rounded_of(drawn_.rounded[i]);
        // A recording that is damaged may name one that the world has not.
        if (body.compound && *body.compound >= scene.compounds.size()) body.compound.reset();
        scene.rounded.push_back(body);
        // For what draws balls alone: as thick as the body is at least.
        scene.diameters.push_back(2 * body.least());
    }
}

std::optional<std::size_t> Stage::place(std::uint64_t id) const {
    const auto at = drawn_.find(id);
    if (!at || places_[*at] < 0) return std::nullopt;
    return static_cast<std::size_t>(places_[*at]);
}

void Stage::add_drawn() {
    render::Scene& scene = frame.scene;
    for (std::size_t i = 0; i < drawn_.labels.size(); ++i)
        if (places_[i] >= 0 && !drawn_.labels[i].empty() && look_.labels.empty())
            scene.notes.push_back({scene.places[static_cast<std::size_t>(places_[i])], drawn_.labels[i]});
    for (const auto& [from, to] : drawn_.lines)
        if (places_[from] >= 0 && places_[to] >= 0)
            scene.strokes.push_back({.from = vec_of(drawn_.positions[from]), .to = vec_of(drawn_.positions[to])});
    for (std::size_t i = 0; i < drawn_.tails.size(); ++i)
        if (places_[i] >= 0 && vec_of(drawn_.tails[i]) != vec_of(drawn_.positions[i]))
            scene.strokes.push_back({.from = vec_of(drawn_.positions[i]), .to = vec_of(drawn_.tails[i]), .radius = kTailRadius});
}

void Stage::call_out(const Callout& callout) {
    if (!drawn_.find(*callout.catom))
        frame.missing.push_back(*callout.catom);
    else if (const auto at = place(*callout.catom))
        frame.scene.callouts.push_back({frame.scene.places[*at], callout.text});
}

void Stage::uncover_lines() {
    render::Scene& scene = frame.scene;
    if (in_plane_)
        for (render::Stroke& stroke : scene.strokes)
            for (Vec* end : {&stroke.from, &stroke.to}) end->z() += kAbove;
    const float size = look_.size.value_or(in_plane_ || scene.strokes.empty() ? 1 : kSmall);
    if (size == 1) return;
    for (render::RoundedBody& body : scene.rounded) body.core *= size, body.rounding *= size, body.size *= size;
    if (scene.diameters.empty()) scene.diameters.assign(scene.places.size(), 1);
    for (float& diameter : scene.diameters) diameter *= size;
}

void Stage::surround() {
    render::Scene& scene = frame.scene;
    add_obstacles(world_, frame.tick, scene);
    add_lamps(world_, scene);
    add_joints(drawn_, places_, scene);
    if (!look_.ground || scene.places.empty()) return;
    float lowest = std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < scene.places.size(); ++i) lowest = std::min(lowest, scene.places[i].z() - scene.reach(i, -Vec::UnitZ()));
    scene.ground = lowest;
}

}  // namespace meld::picture
