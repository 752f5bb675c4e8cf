#include "physics/solver/load_contacts.h"

#include <algorithm>

namespace meld::physics {

namespace {

Vec3 contact_normal(const Batch& batch, int i) { return vector_of_lane(batch.nx, batch.ny, batch.nz, i); }

Vec3 whole_impulse(const Batch& batch, int i) {
    return static_cast<double>(batch.normal_impulse[i]) * contact_normal(batch, i) + vector_of_lane(batch.tx, batch.ty, batch.tz, i);
}

}  // namespace

const Batch& LoadContacts::batch_of(const Contacts& contacts, const Lane& lane) {
    return (lane.obstacle ? contacts.obstacle_contacts(lane.block) : contacts.pairs(lane.block))[lane.batch];
}

LoadContacts::Side LoadContacts::side_of(std::uint32_t slot, const Bodies& bodies, const Composites& composites) {
    if (slot >= bodies.count() || (bodies.properties[slot].flags & kMember) == 0) return {};
    const BodyId body = bodies.properties[slot].id;
    const std::uint32_t composite = composites.composite_of(body);
    const auto members = composites.members(composites.all()[composite]);
    const auto at = std::ranges::lower_bound(members, body, {}, &Composites::Member::id) - members.begin();
    return {composite, composites.all()[composite].first + static_cast<std::uint32_t>(at)};
}

void LoadContacts::find(const Contacts& contacts, const ShapeContacts& shapes, std::size_t blocks, const Bodies& bodies,
                        const Composites& composites) {
    lanes_.clear();
    find_shapes(shapes, blocks, bodies, composites);
    for (std::uint32_t block = 0; block < blocks; ++block)
        for (const bool obstacle : {false, true}) {
            const std::span<const Batch> batches = obstacle ? contacts.obstacle_contacts(block) : contacts.pairs(block);
            for (std::uint32_t n = 0; n < batches.size(); ++n)
                for (int i = 0; i < kLanes; ++i) {
                    const Side a = side_of(batches[n].a[i], bodies, composites),
                               b = obstacle ? Side{} : side_of(batches[n].b[i], bodies, composites);
                    if (a.composite == kNoComposite && b.composite == kNoComposite) continue;
                    lanes_.push_back(
                        {.block = block, .batch = n, .lane = static_cast<std::uint8_t>(i), .obstacle = obstacle, .a = a, .b = b});
                }
        }
}

void LoadContacts::begin_step() {
    pressing_ = false, substep_ = 0;
    for (Lane& lane : lanes_) lane.bounced = 0, lane.before = {};
    for (ShapeLoadLane& lane : shape_lanes_) lane.bounced = {}, lane.kept = {};
}

void LoadContacts::before_bounces(const Contacts& contacts) {
    if (!pressing_ || noted_) return;
    noted_ = true;
    for (Lane& lane : lanes_) lane.before = whole_impulse(batch_of(contacts, lane), lane.lane);
}

void LoadContacts::end_substep(const Contacts& contacts, const ShapeContacts& shapes, const TurningFriction& turning, const Bodies& bodies,
                               const Composites& composites, Loads& loads) {
    if (!pressing_) return;
    pressing_ = false;
    end_shapes(contacts, shapes, turning, bodies, composites, loads);
    // Behind those of shapes.
    const std::uint32_t turn = 2 * substep_ + 1;
    const auto push = [&](const Lane& lane, const Side& side, std::uint32_t slot, Vec3 impulse, Vec3 towards_contact, Vec3 torque) {
        if (side.composite == kNoComposite || composites.all()[side.composite].asleep != 0) return;
        loads.push(composites, side.composite, side.member, impulse, cross(bodies.place[slot].radius * towards_contact, impulse) + torque,
                   {turn, lane.block});
    };
    for (Lane& lane : lanes_) {
        const Batch& batch = batch_of(contacts, lane);
        const int i = lane.lane;
        Vec3 impulse = whole_impulse(batch, i);
        const Vec3 normal = contact_normal(batch, i);
        const auto bounces = lane.obstacle ? contacts.obstacle_bounces(lane.block) : contacts.pair_bounces(lane.block);
        if (!bounces.empty() && bounces[lane.batch].impulse[i] != lane.bounced) {
            impulse = impulse + lane.before + static_cast<double>(bounces[lane.batch].impulse[i] - lane.bounced) * normal;
            lane.bounced = bounces[lane.batch].impulse[i];
        }
        if (impulse == Vec3{}) continue;
        const Vec3 torque = turning.torque(contacts, lane.block, lane.obstacle, lane.batch, i);
        push(lane, lane.a, batch.a[i], -impulse, normal, -torque);
        if (!lane.obstacle) push(lane, lane.b, batch.b[i], impulse, -normal, torque);
    }
}

}  // namespace meld::physics
