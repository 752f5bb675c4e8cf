#include "runtime/sim/bodies/senses/surroundings.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/comm/transport/packets.h"

namespace meld::sim {

using physics::RayGrid;

namespace {

// Around the bodies of a process; empty if it has none.
struct BoxAround {
    static constexpr double kFar = std::numeric_limits<double>::infinity();
    physics::Vec3 low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};
    void add(physics::Vec3 at) {
        low = {std::min(low.x, at.x), std::min(low.y, at.y), std::min(low.z, at.z)};
        high = {std::max(high.x, at.x), std::max(high.y, at.y), std::max(high.z, at.z)};
    }
    bool within(physics::Vec3 at, double reach) const {
        return at.x >= low.x - reach && at.x <= high.x + reach && at.y >= low.y - reach && at.y <= high.y + reach &&
               at.z >= low.z - reach && at.z <= high.z + reach;
    }
};

// No rounding of a box may leave a body out.
constexpr double kBoxShare = 1.0001;

}  // namespace

void BodySurroundings::add(std::uint64_t id, const RayGrid::Thing& thing) {
    const auto index = static_cast<RayGrid::Index>(index_.size());
    index_.emplace(id, index);
    bodies_->set(index, thing);
}

void BodySurroundings::gather(Subdomain& subdomain, const physics::Scene& scene, double reach_m, std::span<const FarPlace> lamps) {
    index_.clear();
    bodies_.emplace(least_radius_m_, greatest_radius_m_);
    BoxAround box;
    for (Catom c = 0; c < subdomain.ensemble.index_count(); ++c) {
        if (!subdomain.owned(c)) continue;
        const std::uint64_t id = subdomain.ensemble.id(c);
        const auto body = static_cast<physics::BodyId>(id);
        const physics::BodyState state = scene.state(body);
        add(id, {state.position_m, scene.shape(body).value_or(physics::BodyShape{{}, scene.radius(body)}), state.orientation});
        box.add(state.position_m);
    }
    if (subdomain.alone()) return;
    // What is on the way to a lamp is in a box around both.
    BoxAround lit = box;
    for (const FarPlace& lamp : lamps)
        if (box.within(lamp.place_m, (lamp.reach_m + greatest_radius_m_) * kBoxShare)) lit.add(lamp.place_m);
    ByteWriter mine;
    mine.write(lit);
    const std::vector<std::byte> boxes = subdomain.comm.allgather(mine.view());
    ByteReader in(boxes, "the boxes of processes");
    std::vector<ByteWriter> out(static_cast<std::size_t>(subdomain.comm.processes()));
    for (int process = 0; process < subdomain.comm.processes(); ++process) {
        const auto theirs = in.read<BoxAround>();
        if (process == subdomain.comm.process()) continue;
        ByteWriter& bytes = out[static_cast<std::size_t>(process)];
        for (const auto& [id, index] : index_) {
            const RayGrid::Thing& thing = bodies_->thing(index);
            if (!theirs.within(thing.centre, (reach_m + thing.shape.radius_m()) * kBoxShare)) continue;
            bytes.write(id);
            bytes.write(thing.centre), bytes.write(thing.turn);
            physics::write_shape(thing.shape, bytes);
        }
    }
    for (const comm::Packet& packet : subdomain.comm.exchange(comm::take_packets(out)))
        for (ByteReader theirs(packet.bytes, "bodies near those of another process"); !theirs.done();) {
            const auto id = theirs.read<std::uint64_t>();
            const auto centre = theirs.read<physics::Vec3>();
            const auto turn = theirs.read<physics::Quat>();
            add(id, {centre, physics::read_shape(theirs), turn});
        }
}

bool BodySurroundings::sees(const physics::Scene& scene, std::uint64_t one, std::uint64_t other) const {
    const auto [low, high] = std::minmax(one, other);
    return in_sight(scene.obstacles(), *bodies_, index_.at(low), index_.at(high));
}

std::optional<double> BodySurroundings::first_on(const physics::Scene& scene, std::uint64_t own, const physics::Ray& ray) const {
    const std::optional<double> wall = physics::first_on(scene.obstacles(), ray), body = bodies_->first_on(ray, index_.at(own));
    if (wall && body) return std::min(*wall, *body);
    return wall ? wall : body;
}

bool BodySurroundings::is_free(const physics::Scene& scene, std::uint64_t own, std::optional<std::uint64_t> other,
                               const physics::Ray& ray) const {
    if (physics::first_on(scene.obstacles(), ray)) return false;
    const auto found = other ? index_.find(*other) : index_.end();
    return !bodies_->blocks(ray, index_.at(own), found == index_.end() ? RayGrid::kNone : found->second);
}

}  // namespace meld::sim
