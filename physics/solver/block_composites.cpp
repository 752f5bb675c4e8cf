// Composites in the block engine: blocks that sleep together, and collisions with restitution.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <utility>

#include "physics/solver/block_engine.h"
#include "runtime/base/assert.h"

namespace meld::physics {

void BlockEngine::link_blocks() {
    linked_.clear(), has_joined_.clear();
    const Composites& composites = world_.composites;
    if (composites.all().empty() && world_.joints.empty()) return;
    const std::span<const Block> blocks = grid_.blocks();
    std::vector<std::uint32_t> block_of(world_.bodies.count());
    for (std::uint32_t b = 0; b < blocks.size(); ++b)
        std::fill_n(block_of.begin() + static_cast<std::ptrdiff_t>(blocks[b].first), blocks[b].count, b);
    linked_.resize(blocks.size());
    std::iota(linked_.begin(), linked_.end(), 0u);
    const auto first = [&](std::uint32_t b) {
        while (linked_[b] != b) b = linked_[b] = linked_[linked_[b]];
        return b;
    };
    for (const Composite& composite : composites.all())
        for (const Composites::Member& member : composites.members(composite)) {
            const std::uint32_t one = first(block_of[composites.members(composite).front().slot]), other = first(block_of[member.slot]);
            linked_[std::max(one, other)] = std::min(one, other);
        }
    for (const Assembly& assembly : world_.joints.assemblies())
        for (const Assembly::Member& member : assembly.members()) {
            if (!member.movable) continue;
            const std::uint32_t one = first(block_of[assembly.members().front().slot]), other = first(block_of[member.slot]);
            linked_[std::max(one, other)] = std::min(one, other);
        }
    for (std::uint32_t b = 0; b < linked_.size(); ++b) linked_[b] = first(b);
    if (!divided()) return;
    has_joined_.resize(blocks.size());
    for (const Composites::Member& member : composites.members()) has_joined_[block_of[member.slot]] = 1;
    for (const Assembly& assembly : world_.joints.assemblies())
        for (const Assembly::Member& member : assembly.members()) has_joined_[block_of[member.slot]] = 1;
}

void BlockEngine::all_or_none(std::vector<std::uint8_t>& of_block) const {
    for (std::uint32_t b = 0; b < linked_.size(); ++b) of_block[linked_[b]] = of_block[linked_[b]] & of_block[b];
    for (std::uint32_t b = 0; b < linked_.size(); ++b) of_block[b] = of_block[linked_[b]];
}

void BlockEngine::let_composites_sleep() {
    rows_.places_changed();
    shape_contacts_.places_changed();
    world_.joints.places_changed();
    for (Composite& composite : world_.composites.all()) {
        const std::uint32_t block = grid_.block_with(world_.composites.members(composite).front().slot);
        composite.asleep = states_[block].asleep ? 1 : 0;
        if (composite.asleep != 0) composite.motion.velocity_m_s = composite.motion.spin_rad_s = {};
    }
}

void BlockEngine::begin_loads() {
    if (!loads_wanted()) {
        load_contacts_fresh_ = false;
        return;
    }
    world_.loads.begin(world_.composites, recomposed_in_step_);
    if (!std::exchange(load_contacts_fresh_, true))
        load_contacts_.find(contacts_, shape_contacts_, states_.size(), world_.bodies, world_.composites);
    load_contacts_.begin_step();
}

void BlockEngine::collect_loads() {
    if (loads_wanted()) load_contacts_.end_substep(contacts_, shape_contacts_, turning_, world_.bodies, world_.composites, world_.loads);
}

// What joints have done in this step to bodies that are parts of composites, the joints in order.
void BlockEngine::add_joint_loads() {
    const Bodies& bodies = world_.bodies;
    const auto add = [&](BodyId body, Vec3 anchor, double sign, const Joint& joint) {
        if (world_.composites.composite_of(body) == kNoComposite) return;
        const Vec3 arm = rotate(joint_pose(bodies, bodies.slot(body)).turn, anchor), impulse = sign * joint.pushed;
        world_.loads.add_push(world_.composites, body, impulse, sign * joint.twisted + cross(arm, impulse));
    };
    for (const Joint& joint : world_.joints.all())
        add(joint.first, joint.first_anchor, -1, joint), add(joint.second, joint.second_anchor, 1, joint);
}

namespace {

void add_single(float (&to)[3], Vec3 v) {
    to[0] += static_cast<float>(v.x), to[1] += static_cast<float>(v.y), to[2] += static_cast<float>(v.z);
}

// One of the two bodies of a contact that collides: a composite, which the contact has an arm on, or a sphere.
struct Collider {
    Composite* composite = nullptr;
    Vec3 arm = {};
    BodyVelocity* sphere = nullptr;
    Vec3 normal = {};
    Vec3 acceleration = {};

    Vec3 velocity() const {
        if (composite) return composite->velocity_at(arm);
        return widened(sphere->linear) - cross(widened(sphere->surface), normal);
    }
    // How much an impulse of 1 in this direction changes the velocity in it.
    double lightness(Vec3 direction) const {
        if (composite) {
            if (!composite->moves_freely()) return 0;
            const Vec3 turning = rotate(conjugate(composite->motion.turn), cross(arm, direction));
            return 1 / composite->mass_kg + dot(turning, composite->inverse_inertia * turning);
        }
        const Vec3 across = direction - dot(direction, normal) * normal;
        return static_cast<double>(sphere->inverse_mass) + static_cast<double>(sphere->inverse_surface_mass) * dot(across, across);
    }
    void push(Vec3 impulse) const {
        if (composite) {
            if (!composite->moves_freely()) return;
            CompositeMotion& motion = composite->motion;
            motion.velocity_m_s = motion.velocity_m_s + (1 / composite->mass_kg) * impulse;
            const Vec3 turning = composite->inverse_inertia * rotate(conjugate(motion.turn), cross(arm, impulse));
            motion.spin_rad_s = motion.spin_rad_s + rotate(motion.turn, turning);
            return;
        }
        add_single(sphere->linear, static_cast<double>(sphere->inverse_mass) * impulse);
        add_single(sphere->surface, -static_cast<double>(sphere->inverse_surface_mass) * cross(normal, impulse));
    }
};

struct Collision {
    Collider a, b;
    Vec3 normal;
    double gap_m, restitution, friction;

    double parting() const { return dot(b.velocity() - a.velocity(), normal); }
    bool bounces(const BounceRule& rule) const {
        const double speed = parting();
        return restitution > 0 && speed < -static_cast<double>(rule.min_speed) && a.lightness(normal) + b.lightness(normal) > 0 &&
               gap_m < static_cast<double>(rule.margin) - static_cast<double>(rule.step_s) * speed;
    }
    // The impulse along the normal; see speed_after in contact_kernels.cpp.
    double collide(const BounceRule& rule) const {
        const double before = parting(), half = 0.5 * static_cast<double>(rule.step_s) * dot(b.acceleration - a.acceleration, normal);
        const double approach = std::max(-(before + half), 0.0);
        const double gained = -2 * dot(b.acceleration - a.acceleration, normal) * std::max(gap_m, 0.0);
        const double impact_squared = std::max(approach * approach + gained, 0.0);
        const double here = std::sqrt(std::max(restitution * restitution * impact_squared - gained, 0.0));
        const double after = std::min(here, approach) - half;
        const double along = std::max(after - before, 0.0) / (a.lightness(normal) + b.lightness(normal));
        push(along * normal);
        const Vec3 apart = b.velocity() - a.velocity(), slip = apart - dot(apart, normal) * normal;
        const double speed = length(slip);
        if (speed == 0) return along;
        const Vec3 direction = (1 / speed) * slip;
        const double stops = speed / (a.lightness(direction) + b.lightness(direction));
        push(-std::min(stops, friction * along) * direction);
        return along;
    }
    void push(Vec3 impulse) const { a.push(-impulse), b.push(impulse); }
};

// The lanes of a block whose body a is a member of a composite: f(batch, its bounces, lane, collision).
template <class F>
void each_collision(World& world, Contacts& contacts, const CompositeRows& rows, std::uint32_t block, const BounceRule& rule, const F& f) {
    const auto joint = contacts.joint_pairs(block), mixed = contacts.mixed_pairs(block), obstacles = contacts.mixed_obstacles(block);
    if (joint.empty() && mixed.empty() && obstacles.empty()) return;
    const CompositeRow* row = rows.rows_of(block).data();
    const Vec3 gravity = widened(rule.gravity);
    const auto composite_side = [&](std::uint32_t copy, Vec3 arm) {
        Composite& composite = world.composites.all()[rows.composite_of(copy)];
        const Vec3 acceleration = composite.moves_freely() ? gravity + composite.pushed_m_s2 : Vec3{};
        return Collider{.composite = &composite, .arm = arm, .acceleration = acceleration};
    };
    const auto sphere_side = [&](std::uint32_t slot, Vec3 normal) {
        BodyVelocity& sphere = world.bodies.velocity[slot];
        Collider side{.sphere = &sphere, .normal = normal};
        if (sphere.inverse_mass == 0) return side;
        side.acceleration = gravity;
        for (const Wrench* wrenches : rule.wrenches)
            if (wrenches) side.acceleration = side.acceleration + static_cast<double>(sphere.inverse_mass) * widened(wrenches[slot].force);
        return side;
    };
    const auto visit = [&](std::span<Batch> batches, std::span<Bounce> bounces, bool is_joint) {
        for (std::size_t n = 0; n < batches.size(); ++n, ++row)
            for (int i = 0; i < kLanes; ++i) {
                Batch& batch = batches[n];
                if (batch.a[i] >= world.bodies.count()) continue;
                const Vec3 normal = vector_of_lane(batch.nx, batch.ny, batch.nz, i);
                f(batch, bounces[n], i,
                  Collision{.a = composite_side(row->a[i], vector_of_lane(row->ax, row->ay, row->az, i)),
                            .b = is_joint ? composite_side(row->b[i], vector_of_lane(row->bx, row->by, row->bz, i))
                                          : sphere_side(batch.b[i], normal),
                            .normal = normal,
                            .gap_m = static_cast<double>(batch.gap[i]),
                            .restitution = static_cast<double>(bounces[n].restitution[i]),
                            .friction = static_cast<double>(batch.friction[i])});
            }
    };
    const std::size_t plain = contacts.plain_pairs(block).size();
    visit(joint, contacts.pair_bounces(block).subspan(plain, joint.size()), true);
    visit(mixed, contacts.pair_bounces(block).subspan(plain + joint.size()), false);
    visit(obstacles, contacts.obstacle_bounces(block).subspan(contacts.plain_obstacles(block).size()), false);
}

}  // namespace

bool BlockEngine::find_composite_bounces(const BounceRule& rule, Workers& workers) {
    composites_bounce_.clear();
    if (rows_.empty()) return false;
    // This brings the arms up to date.
    rows_.begin(contacts_, shape_contacts_, active_, world_.bodies, world_.composites, workers);
    rows_.collect(world_.bodies, world_.composites, workers);
    composites_bounce_.resize(states_.size());
    std::atomic<bool> found{false};
    for_blocks(active_, workers, [&](int, std::uint32_t block) {
        bool bounces = false;
        each_collision(world_, contacts_, rows_, block, rule,
                       [&](Batch&, Bounce&, int, const Collision& collision) { bounces = bounces || collision.bounces(rule); });
        bounces = bounces || shape_contacts_.any_bounces(world_.bodies, block, rule, &world_.composites);
        if (!bounces) return;
        composites_bounce_[block] = 1;
        found = true;
    });
    return found;
}

void BlockEngine::bounce_composites(const BounceRule& rule, std::uint32_t block) {
    each_collision(world_, contacts_, rows_, block, rule, [&](Batch& batch, Bounce& bounce, int i, const Collision& collision) {
        if (!collision.bounces(rule)) return;
        bounce.impulse[i] += static_cast<float>(collision.collide(rule));
        // The impulse from before no longer presses.
        batch.normal_impulse[i] = batch.tx[i] = batch.ty[i] = batch.tz[i] = 0;
    });
    shape_contacts_.bounce(world_.bodies, block, rule, &world_.composites);
}

std::vector<std::uint32_t> BlockEngine::blocks_of_composite_bounces() const {
    std::vector<std::uint32_t> blocks;
    for (std::uint32_t block = 0; block < composites_bounce_.size(); ++block)
        if (composites_bounce_[block] != 0) blocks.push_back(block);
    return blocks;
}

}  // namespace meld::physics
