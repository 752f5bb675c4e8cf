// Copies of composites for the contacts of bodies with shapes. A copy is an entry behind those of the bodies, so the passes over such
// contacts move it as they move a body: its surface velocity is its angular velocity times a length of the composite, which is kept as
// the radius of the entry, and its turning is the inverse of the inertia in that unit.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "physics/solver/composite_rows.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

constexpr std::size_t kArmBlocksPerJob = 4;

// About the radius of gyration.
double unit_of(const Composite& composite) {
    return std::sqrt((composite.inertia.xx + composite.inertia.yy + composite.inertia.zz) / (2 * composite.mass_kg));
}

}  // namespace

void CompositeRows::lay_out_entries(ShapeContacts& shapes, std::size_t blocks, Bodies& bodies, const Composites& composites) {
    shapes.forget_moved();
    const auto mover = [&](std::uint32_t slot) {
        return slot < bodies.count() ? composites.mover_of(bodies.properties[slot].id) : kNoComposite;
    };
    auto next = static_cast<std::uint32_t>(bodies.velocity.size());
    // By composite: its last entry, if that is one of this block.
    std::vector<std::uint32_t> last(composites.all().size(), 0);
    for (std::size_t block = 0; block < blocks; ++block) {
        const std::uint32_t first = next;
        const auto entry_of = [&](std::uint32_t composite) {
            if (last[composite] >= first) return last[composite];
            entries_.push_back({composite, next, block});
            return last[composite] = next++;
        };
        for (ShapeBatch& batch : shapes.batches(block)) {
            MovedLanes* moved = nullptr;
            for (int i = 0; i < kLanes; ++i) {
                const std::uint32_t a = mover(batch.a[i]), b = mover(batch.b[i]);
                if (a == kNoComposite && b == kNoComposite) continue;
                if (moved == nullptr) moved = &shapes.add_moved(batch);
                if (a != kNoComposite) moved->a[i] = entry_of(a);
                if (b != kNoComposite) moved->b[i] = entry_of(b);
            }
        }
    }
    sort_entries(composites);
    bodies.velocity.resize(next), bodies.place.resize(next);
    shapes.add_turnings(next);
    for (const Entry& entry : entries_) {
        bodies.velocity[entry.at] = {};
        bodies.place[entry.at] = {0, 0, 0, unit_of(composites.all()[entry.composite])};
    }
}

void CompositeRows::sort_entries(const Composites& composites) {
    std::ranges::stable_sort(entries_, {}, &Entry::composite);
    first_entry_.assign(composites.all().size() + 1, 0);
    for (const Entry& entry : entries_) ++first_entry_[entry.composite + 1];
    for (std::size_t c = 0; c + 1 < first_entry_.size(); ++c) first_entry_[c + 1] += first_entry_[c];
}

std::uint32_t CompositeRows::add_entry(std::uint32_t composite, ShapeContacts& shapes, Bodies& bodies, const Composites& composites) const {
    const auto at = static_cast<std::uint32_t>(bodies.velocity.size());
    bodies.velocity.push_back(BodyVelocity{});
    bodies.place.push_back({0, 0, 0, unit_of(composites.all()[composite])});
    shapes.add_turnings(at + 1);
    return at;
}

void CompositeRows::begin_entry(std::uint32_t at, ShapeContacts& shapes, Bodies& bodies, const Composite& composite, double share) const {
    const CompositeMotion& motion = composite.motion;
    BodyVelocity& velocity = bodies.velocity[at];
    const double unit_m = bodies.place[at].radius;
    set_single(velocity.linear, motion.velocity_m_s);
    set_single(velocity.surface, unit_m * motion.spin_rad_s);
    if (fresh_) return;
    velocity.inverse_mass = velocity.inverse_surface_mass = 0;
    Turning turning{};
    if (composite.moves_freely()) {
        velocity.inverse_mass = static_cast<float>(share / composite.mass_kg);
        const Symmetric lightness = turned(composite.inverse_inertia, motion.turn);
        const double entries[] = {lightness.xx, lightness.xy, lightness.xz, lightness.yy, lightness.yz, lightness.zz};
        for (int i = 0; i < 6; ++i) turning.entries[i] = static_cast<float>(unit_m * unit_m * composite.mass_kg * entries[i]);
    }
    shapes.set_turning(at, turning);
}

void CompositeRows::place_arms(ShapeContacts& shapes, std::span<const std::uint32_t> blocks, const Bodies& bodies,
                               const Composites& composites, Workers& workers) const {
    const auto place = [&](std::uint32_t slot, std::uint32_t at, int i, Lanes& scale, Lanes& x, Lanes& y, Lanes& z) {
        if (slot == at) return;
        const Composite& composite = composites.all()[composites.mover_of(bodies.properties[slot].id)];
        const Place& member = bodies.place[slot];
        const double share = 1 / bodies.place[at].radius;
        const Vec3 offset = share * (centre_of(member) - composite.motion.centre_m);
        scale[i] = static_cast<float>(share * member.radius);
        x[i] = static_cast<float>(offset.x), y[i] = static_cast<float>(offset.y), z[i] = static_cast<float>(offset.z);
    };
    workers.run((blocks.size() + kArmBlocksPerJob - 1) / kArmBlocksPerJob, [&](int, std::size_t job) {
        const std::size_t end = std::min(blocks.size(), (job + 1) * kArmBlocksPerJob);
        for (std::size_t n = job * kArmBlocksPerJob; n < end; ++n)
            for (const ShapeBatch& batch : std::as_const(shapes).batches(blocks[n])) {
                if (batch.moved == kNoSlot) continue;
                MovedLanes& moved = shapes.moved_lanes()[batch.moved];
                for (int i = 0; i < kLanes; ++i) {
                    place(batch.a[i], moved.a[i], i, moved.a_scale, moved.ax, moved.ay, moved.az);
                    place(batch.b[i], moved.b[i], i, moved.b_scale, moved.bx, moved.by, moved.bz);
                }
            }
    });
}

MovedLanes& ShapeContacts::add_moved(ShapeBatch& batch) {
    batch.moved = static_cast<std::uint32_t>(moved_.size());
    MovedLanes& moved = moved_.emplace_back();
    std::copy_n(batch.a, kLanes, moved.a), std::copy_n(batch.b, kLanes, moved.b);
    const Lanes nothing = physics::lanes(0);
    moved.a_scale = moved.b_scale = physics::lanes(1);
    moved.ax = moved.ay = moved.az = moved.bx = moved.by = moved.bz = nothing;
    return moved;
}

void ShapeContacts::forget_moved() {
    for (ShapeBatch& batch : batches_) batch.moved = kNoSlot;
    moved_.clear();
}

}  // namespace meld::physics
