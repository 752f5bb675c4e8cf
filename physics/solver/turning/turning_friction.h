// Friction against rolling and spinning of all contacts (turning_lanes.h): lanes beside the batches of contacts, only where some material
// resists.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "physics/bodies/buffer.h"
#include "physics/bodies/lanes.h"
#include "physics/solver/contacts.h"
#include "physics/solver/shapes/shape_contacts.h"

namespace meld::physics {

// Beside a batch of contacts. Impulses of torque, N m s, act on b, and reversed on a, as seen from the world.
struct alignas(32) TurningLanes {
    // The radii of the patch, m.
    Lanes rolling, spinning;
    // What a surface velocity is to be multiplied with to be an angular velocity, 1/m. 0 for what has none.
    Lanes a_curvature, b_curvature;
    Lanes x, y, z;
};

class TurningFriction {
  public:
    // What it needs of the scene.
    struct Setup {
        const Bodies& bodies;
        const Obstacles& obstacles;
        std::span<const Material> materials;
        const Contacts& contacts;
        const ShapeContacts& shapes;
    };
    bool empty() const { return lanes_.empty(); }
    // The batches are gone.
    void forget() { lanes_ = {}; }
    // For new batches, those of composites too: all blocks. Cost: one pass over the contacts.
    void lay_out(const Setup& setup, std::size_t blocks, Workers& workers);
    // Impulses of torque begin from zero in each substep: those of these blocks.
    void begin_substep(const Contacts& contacts, const ShapeContacts& shapes, std::span<const std::uint32_t> blocks);

    // Beside the batches of a block, one each.
    TurningLanes* pairs(const Contacts& contacts, std::size_t block) { return lanes_.data() + contacts.first_pair_batch(block); }
    TurningLanes* obstacles(const Contacts& contacts, std::size_t block) {
        return lanes_.data() + contacts.pair_batch_count() + contacts.first_obstacle_batch(block);
    }
    TurningLanes* of_shapes(const Contacts& contacts, const ShapeContacts& shapes, std::size_t block) {
        return lanes_.data() + contacts.pair_batch_count() + contacts.obstacle_batch_count() + shapes.first_batch(block);
    }
    // The torque on b of a lane in the present substep, as an impulse, N m s.
    Vec3 torque(const Contacts& contacts, std::uint32_t block, bool obstacle, std::uint32_t batch, int lane) const;
    Vec3 torque_of_shapes(const Contacts& contacts, const ShapeContacts& shapes, std::uint32_t block, std::uint32_t batch, int lane) const;
    std::size_t bytes() const { return lanes_.capacity() * sizeof(TurningLanes); }

  private:
    // First those of all pair batches, then those of obstacle batches and of batches of shapes.
    Buffer<TurningLanes> lanes_;
};

}  // namespace meld::physics
