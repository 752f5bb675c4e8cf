#include "physics/solver/saved_bodies.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace meld::physics {

namespace {

// Named to the last byte, so that no byte of a file is left to chance.
struct SavedBody {
    double place[3];
    double radius;
    float orientation[4];
    float linear[3], surface[3];
    float drift[3];
    float mass, inertia_factor;
    std::uint32_t id;
    std::uint16_t still_ticks;
    std::uint8_t material, flags;
    std::array<std::int16_t, 6> marked;
};
static_assert(sizeof(SavedBody) == 112);

struct SavedFeatures {
    double energy_j;
    std::uint32_t on, reversed;
    float charge_j;
    std::uint32_t table;
};

// Whether bodies have magnets and the like, and some of these currents, voltages or heat.
enum class HasFeatures : std::uint8_t { No, Yes, Supplied };

SavedBody saved(const Bodies& bodies, std::uint32_t slot) {
    const Place& place = bodies.place[slot];
    const Orientation& orientation = bodies.orientation[slot];
    const BodyVelocity& v = bodies.velocity[slot];
    const Drift& drift = bodies.drift[slot];
    const BodyProperties& properties = bodies.properties[slot];
    return {{place.x, place.y, place.z},
            place.radius,
            {orientation.w, orientation.x, orientation.y, orientation.z},
            {v.linear[0], v.linear[1], v.linear[2]},
            {v.surface[0], v.surface[1], v.surface[2]},
            {drift.x, drift.y, drift.z},
            properties.mass,
            properties.inertia_factor,
            properties.id,
            properties.still_ticks,
            properties.material,
            static_cast<std::uint8_t>(properties.flags & (kFixed | kRemoved | kShaped)),
            properties.marked};
}

Result<void> add(World& world, Holds holds, const SavedBody& b) {
    Bodies& bodies = world.bodies;
    if (b.id >= kMaxBodies || bodies.has(b.id) || !(b.radius > 0) || !(b.mass > 0) || b.material >= world.materials.size())
        return damaged_snapshot(fmt::format("has an invalid body {}", b.id));
    bodies.add({b.place[0], b.place[1], b.place[2], b.radius}, {b.orientation[0], b.orientation[1], b.orientation[2], b.orientation[3]},
               {{b.linear[0], b.linear[1], b.linear[2]}, 0, {b.surface[0], b.surface[1], b.surface[2]}, 0},
               {.id = b.id,
                .mass = b.mass,
                .inertia_factor = b.inertia_factor,
                .material = b.material,
                .flags = static_cast<std::uint8_t>((b.flags & (kFixed | kRemoved | kShaped)) | (holds == Holds::Ghosts ? kGhost : 0)),
                .still_ticks = b.still_ticks,
                .marked = b.marked});
    const std::uint32_t slot = bodies.slot(b.id);
    bodies.drift[slot] = {b.drift[0], b.drift[1], b.drift[2]};
    bodies.restore_masses(slot);
    return {};
}

}  // namespace

tl::unexpected<Error> damaged_snapshot(const std::string& what) {
    return fail("the snapshot of the bodies " + what, "It is damaged, or was made by another version", ExitCode::RecordingRefused);
}

void save_bodies(const World& world, std::span<const std::uint32_t> slots, ByteWriter& out) {
    const Bodies& bodies = world.bodies;
    out.reserve(out.size() + slots.size() * sizeof(SavedBody) + 64);
    out.write_count(slots.size());
    for (const std::uint32_t slot : slots) out.write(saved(bodies, slot));
    for (const std::uint32_t slot : slots)
        if ((bodies.properties[slot].flags & kShaped) != 0) write_shape(world.shapes.shape(bodies.properties[slot].id), out);
    const bool supplied =
        std::ranges::any_of(slots, [&](std::uint32_t slot) { return !world.coils.of(bodies.properties[slot].id).empty(); });
    out.write(bodies.features.empty() ? HasFeatures::No : supplied ? HasFeatures::Supplied : HasFeatures::Yes);
    for (std::size_t i = 0; !bodies.features.empty() && i < slots.size(); ++i) {
        const Bodies::FeatureState& f = bodies.features[slots[i]];
        out.write(SavedFeatures{bodies.energy[slots[i]], f.on, f.reversed, f.charge_j, f.table});
    }
    for (std::size_t i = 0; supplied && i < slots.size(); ++i) world.coils.write(bodies.properties[slots[i]].id, out);
    // The array is there if a body was ever pushed; mostly all have been let go.
    out.write(!bodies.wrenches.empty());
    for (std::uint32_t i = 0; !bodies.wrenches.empty() && i < slots.size(); ++i) {
        const Wrench none{}, &wrench = bodies.wrenches[slots[i]];
        if (std::memcmp(&wrench, &none, sizeof none) == 0) continue;
        out.write(i);
        out.write(wrench);
    }
    if (!bodies.wrenches.empty()) out.write(kNoSlot);
}

Result<void> load_bodies(World& world, Holds holds, ByteReader& in) {
    Bodies& bodies = world.bodies;
    const std::uint32_t count = in.read_count(sizeof(SavedBody)), first = static_cast<std::uint32_t>(bodies.count());
    for (std::uint32_t i = 0; i < count; ++i)
        if (auto added = add(world, holds, in.read<SavedBody>()); !added) return added;
    for (std::uint32_t slot = first; slot < first + count; ++slot) {
        if ((bodies.properties[slot].flags & kShaped) == 0) continue;
        const BodyShape shape = read_shape(in);
        if (in.failed()) return {};
        if (shape.is_sphere() || !check(shape)) return damaged_snapshot("has an invalid shape");
        if (auto set = world.shapes.set(bodies.properties[slot].id, shape); !set) return set;
    }
    const auto saved_features = in.read<HasFeatures>();
    const bool has_features = saved_features != HasFeatures::No;
    if (has_features) bodies.need_features();
    for (std::uint32_t i = 0; has_features && i < count; ++i) {
        const auto saved = in.read<SavedFeatures>();
        if (saved.table >= world.tables.size()) return damaged_snapshot(fmt::format("names a table of features {}", saved.table));
        bodies.features[first + i] = {saved.on, saved.reversed, saved.charge_j, 0, static_cast<std::uint16_t>(saved.table)};
        bodies.energy[first + i] = saved.energy_j;
    }
    if (saved_features == HasFeatures::Supplied && !world.coils.possible()) return damaged_snapshot("has currents of bodies without coils");
    for (std::uint32_t i = 0; i < count && !in.failed(); ++i) {
        const BodyId id = bodies.properties[first + i].id;
        if (saved_features == HasFeatures::Supplied)
            world.coils.read(id, in);
        else
            world.coils.forget(id);
    }
    if (!in.read<bool>()) return {};
    bodies.need_wrenches();
    for (auto at = in.read<std::uint32_t>(); at < count && !in.failed(); at = in.read<std::uint32_t>())
        bodies.wrenches[first + at] = in.read<Wrench>();
    return {};
}

void each_saved_place(ByteReader& in, const std::function<void(BodyId, Vec3)>& visit) {
    for (auto left = in.read_count(sizeof(SavedBody)); left > 0; --left) {
        const auto body = in.read<SavedBody>();
        visit(body.id, {body.place[0], body.place[1], body.place[2]});
    }
}

}  // namespace meld::physics
