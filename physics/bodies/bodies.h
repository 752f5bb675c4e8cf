// The bodies as arrays, one entry per slot. Slots follow space (the block grid sorts them), so neighbours are near in memory; the caller's
// ids do not change. These arrays are the state of the world; ODE's objects are copies made when needed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/bodies/buffer.h"
#include "physics/bodies/types.h"
#include "runtime/base/assert.h"
#include "runtime/base/process/parallel_for.h"

namespace meld::physics {

inline constexpr std::uint32_t kNoSlot = 0xffffffff;

// What the contact solver reads and writes of a body, half a cache line. `surface` is the surface velocity, radius times angular
// velocity: with it, touching spheres need no lever arms. `inverse_surface_mass` is radius^2 / moment of inertia. Both inverse masses
// are 0 for fixed and sleeping bodies and for members of composites, the second for bodies with shapes, too.
struct alignas(32) BodyVelocity {
    float linear[3];
    float inverse_mass;
    float surface[3];
    float inverse_surface_mass;
};

inline Vec3 velocity_of(const BodyVelocity& velocity) {
    const float(&v)[3] = velocity.linear;
    return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

inline Vec3 widened(const float (&v)[3]) { return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])}; }
inline void set_single(float (&to)[3], Vec3 v) {
    to[0] = static_cast<float>(v.x), to[1] = static_cast<float>(v.y), to[2] = static_cast<float>(v.z);
}

struct alignas(32) Place {
    double x, y, z, radius;
};
inline Vec3 centre_of(const Place& place) { return {place.x, place.y, place.z}; }

struct alignas(16) Orientation {
    float w, x, y, z;
};
inline Quat widened(const Orientation& o) {
    return {static_cast<double>(o.w), static_cast<double>(o.x), static_cast<double>(o.y), static_cast<double>(o.z)};
}

// The number of still ticks of a body: kStays if its block stays where it is, otherwise counted up to kStillAtMost.
inline constexpr std::uint16_t kStays = 0xffff, kStillAtMost = 0xfffe;

// Properties of a body that seldom change.
struct BodyProperties {
    std::uint32_t id;
    float mass;
    // Moment of inertia / (mass * radius^2).
    float inertia_factor;
    std::uint8_t material;
    std::uint8_t flags;
    std::uint16_t still_ticks;
    // Linear and surface velocity some time ago, while its block is watched, as shares of the speed that counts as still: kMarkedStill.
    std::array<std::int16_t, 6> marked = {};
};
inline constexpr std::int16_t kMarkedStill = 0x7fff;

// kMember: a composite moves it (composites.h). kShaped: it is no sphere (body_shape.h).
enum BodyFlag : std::uint8_t { kFixed = 1, kGhost = 2, kRemoved = 4, kMember = 8, kShaped = 16 };

// A force and a torque, N and N m.
struct Wrench {
    float force[3];
    float torque[3];
};

// Movement since the candidate list was made.
struct Drift {
    float x, y, z;
};

class Bodies {
  public:
    std::size_t count() const { return properties.size(); }
    bool has(BodyId id) const { return id < slot_of_id_.size() && slot_of_id_[id] != kNoSlot; }
    // The slot must exist.
    std::uint32_t slot(BodyId id) const {
        MELD_EXPECT(has(id), "body {}", id);
        return slot_of_id_[id];
    }

    // Appends a body in the last slot; the entries behind the bodies are dropped.
    void add(const Place& where, const Orientation& turned, const BodyVelocity& moving, const BodyProperties& what);
    // Reserves memory for `bodies` bodies with ids below `ids`.
    void reserve(std::size_t bodies, std::size_t ids);
    // Entry i of every array becomes the former entry order[i]; slots that `order` omits are dropped. There is room for `motionless`
    // entries behind the bodies.
    void permute(std::span<const std::uint32_t> order, Workers& workers, std::size_t motionless = 0);

    // Sets the inverse masses that the body's properties imply; sleep sets them to 0.
    void restore_masses(std::uint32_t slot);

    // The optional arrays are empty until first used, then as long as the others.
    void need_wrenches() { wrenches.resize(count()); }
    void need_features() {
        features.reserve(properties.capacity()), energy.reserve(properties.capacity());
        features.resize(count()), energy.resize(count());
    }

    struct FeatureState {
        std::uint32_t on = 0;
        std::uint32_t reversed = 0;
        // C V^2 of the body's plates, in this tick and the one before.
        float charge_j = 0;
        float charge_before_j = 0;
        std::uint16_t table = 0;
    };

    // These two may be longer than count(): behind the bodies is one motionless entry per block, for lanes without a body.
    Buffer<BodyVelocity> velocity;
    Buffer<Place> place;
    Buffer<Orientation> orientation;
    Buffer<BodyProperties> properties;
    Buffer<Drift> drift;
    // External forces, kept until changed.
    std::vector<Wrench> wrenches;
    std::vector<FeatureState> features;
    // Energy drawn since the start, J.
    std::vector<double> energy;

    std::size_t bytes() const;

  private:
    std::vector<std::uint32_t> slot_of_id_;
};

inline std::vector<std::uint32_t> all_slots(const Bodies& bodies) {
    std::vector<std::uint32_t> slots(bodies.count());
    for (std::uint32_t slot = 0; slot < slots.size(); ++slot) slots[slot] = slot;
    return slots;
}

}  // namespace meld::physics
