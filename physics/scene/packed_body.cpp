#include "physics/scene/packed_body.h"

#include <fmt/format.h>

#include <algorithm>

namespace meld::physics {

namespace {

// Its shape follows if it is no sphere, what its connections carry at most if somebody wants loads, and its currents and heat.
struct PackedBody {
    Place place;
    Orientation orientation;
    BodyVelocity velocity;
    BodyProperties properties;
    Wrench wrench;
    Bodies::FeatureState features;
    double energy_j;
};

}  // namespace

void pack_body(const World& world, std::uint32_t slot, ByteWriter& out) {
    const Bodies& bodies = world.bodies;
    const BodyId id = bodies.properties[slot].id;
    out.write(PackedBody{bodies.place[slot], bodies.orientation[slot], bodies.velocity[slot], bodies.properties[slot],
                         bodies.wrenches.empty() ? Wrench{} : bodies.wrenches[slot],
                         bodies.features.empty() ? Bodies::FeatureState{} : bodies.features[slot],
                         bodies.energy.empty() ? 0 : bodies.energy[slot]});
    if ((bodies.properties[slot].flags & kShaped) != 0) write_shape(world.shapes.shape(id), out);
    if (world.loads.wanted()) out.write(world.loads.limits_of(id));
    if (world.coils.possible()) world.coils.write(id, out);
}

Result<void> unpack_body(World& world, ByteReader& in, const std::function<bool(const Place&)>& is_ours) {
    Bodies& bodies = world.bodies;
    PackedBody body = in.read<PackedBody>();
    const BodyId id = body.properties.id;
    if (bodies.has(id)) return fail(fmt::format("body {} came from another part and is here already", id), "Give each body to one part");
    const bool ours = is_ours(body.place);
    world.shapes.forget(id);
    if ((body.properties.flags & kShaped) != 0)
        if (auto set = world.shapes.set(id, read_shape(in)); !set) return set;
    body.properties.flags = static_cast<std::uint8_t>((body.properties.flags & (kFixed | kShaped)) | (ours ? 0 : kGhost));
    bodies.add(body.place, body.orientation, body.velocity, body.properties);
    if (world.has_features()) bodies.need_features();
    const std::uint32_t slot = bodies.slot(id);
    const Wrench& wrench = body.wrench;
    if (std::any_of(wrench.force, wrench.force + 3, [](float f) { return f != 0; }) ||
        std::any_of(wrench.torque, wrench.torque + 3, [](float f) { return f != 0; }))
        bodies.need_wrenches();
    if (!bodies.wrenches.empty()) bodies.wrenches[slot] = wrench;
    if (world.has_features()) bodies.features[slot] = body.features, bodies.energy[slot] = body.energy_j;
    bodies.restore_masses(slot);
    if (world.loads.wanted()) world.loads.set_limits(id, in.read<BreakingLimits>());
    if (world.coils.possible()) world.coils.read(id, in);
    return {};
}

}  // namespace meld::physics
