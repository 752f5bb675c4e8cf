#include "runtime/sim/divided_bodies.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "runtime/base/assert.h"
#include "runtime/sim/bytes.h"

namespace meld::sim {

namespace {

// The curve goes through as many blocks as a lattice has bricks; those beyond share the owners of the last.
constexpr double kFarthest = (world::kCellLimit >> 3) - 1;

// What a part of the physics has to say, as packets.
std::vector<comm::Packet> packets_of(physics::Part::Messages messages) {
    std::vector<comm::Packet> packets;
    for (auto& [to, bytes] : messages)
        if (!bytes.empty()) packets.push_back({to, std::move(bytes)});
    return packets;
}

}  // namespace

std::vector<std::vector<std::byte>> gather_bytes(PartState& part, const std::vector<std::byte>& mine) {
    return part.alone() ? std::vector<std::vector<std::byte>>{mine} : part.comm.allgather_any(mine);
}

std::vector<comm::Packet> exchange_bytes(PartState& part, std::vector<std::vector<std::byte>>& by_part) {
    std::vector<comm::Packet> packets;
    for (std::size_t to = 0; to < by_part.size(); ++to) {
        if (by_part[to].empty()) continue;
        MELD_EXPECT(static_cast<int>(to) != part.comm.part());
        packets.push_back({static_cast<int>(to), std::move(by_part[to])});
    }
    return part.comm.exchange(std::move(packets));
}

Result<void> agree_on_error(PartState& part, const Result<void>& mine) {
    if (part.alone()) return mine;
    std::vector<std::byte> bytes;
    if (!mine) {
        put_text(bytes, mine.error().problem);
        put_text(bytes, mine.error().suggestion);
        put(bytes, mine.error().code);
    }
    for (const auto& told : gather_bytes(part, bytes)) {
        if (told.empty()) continue;
        const std::byte* at = told.data();
        Error error;
        error.problem = take_text(at);
        error.suggestion = take_text(at);
        error.code = take_value<ExitCode>(at);
        return tl::unexpected<Error>(error);
    }
    return {};
}

DividedBodies::DividedBodies(PartState& part, physics::Scene& scene) {
    bodies_ = std::make_unique<physics::Part>(scene, [this](physics::BlockCoordinates block) { return owner(block); }, part.comm.part());
    const double block_m = bodies_->block_m();
    const auto key_of = [&](physics::Vec3 p) {
        const auto at = [&](double x) { return static_cast<std::int32_t>(std::clamp(std::floor(x / block_m), -kFarthest, kFarthest)); };
        return physics::BlockCoordinates{at(p.x), at(p.y), at(p.z)};
    };
    std::map<world::BrickKey, std::uint32_t> mine, all;
    for (const physics::BodyId body : scene.bodies()) {
        const physics::BlockCoordinates block = key_of(scene.state(body).position_m);
        ++mine[curve_.brick_key({block.x, block.y, block.z})];
    }
    std::vector<std::byte> bytes;
    for (const auto& [key, count] : mine) {
        put(bytes, key);
        put(bytes, count);
    }
    for (const auto& from : gather_bytes(part, bytes))
        for (const std::byte* at = from.data(); at != from.data() + from.size();) {
            const auto key = take_value<world::BrickKey>(at);
            all[key] += take_value<std::uint32_t>(at);
        }
    partition_.emplace(std::vector<std::pair<world::BrickKey, std::uint32_t>>(all.begin(), all.end()), part.comm.parts());
}

int DividedBodies::owner(physics::BlockCoordinates block) const {
    const auto [at, made] = owners_.try_emplace(physics::pack(block), 0);
    if (!made) return at->second;
    const auto within = [](std::int32_t x) { return std::clamp(x, static_cast<std::int32_t>(-kFarthest), static_cast<std::int32_t>(kFarthest)); };
    at->second = partition_->owner(curve_.brick_key({within(block.x), within(block.y), within(block.z)}));
    return at->second;
}

Result<bool> DividedBodies::redistribute(PartState& part, double step_s, int substeps) {
    std::vector<std::byte> wish;
    put(wish, bodies_->must_rebuild(step_s, substeps));
    const std::vector<std::byte> wishes = part.comm.allgather(wish);
    const std::byte* at = wishes.data();
    bool any = false;
    for (int p = 0; p < part.comm.parts(); ++p) any = take_value<bool>(at) || any;
    if (!any) return false;
    Result<void> fine;
    for (const comm::Packet& packet : part.comm.exchange(packets_of(bodies_->pack_bodies(part.workers))))
        if (auto done = bodies_->unpack_bodies(packet.bytes); !done && fine) fine = done;
    bodies_->unpacked();
    if (auto agreed = agree_on_error(part, fine); !agreed) return tl::unexpected<Error>(agreed.error());
    return true;
}

Result<physics::StepReport> DividedBodies::step(PartState& part, double step_s, int substeps) {
    Result<void> fine;
    for (const physics::Stage& stage : bodies_->stages(step_s, substeps)) {
        if (fine) fine = bodies_->run(stage, part.workers);
        if (!stage.must_exchange()) continue;
        // A part that has failed says nothing more; the others find out at the end.
        const std::vector<comm::Packet> received = part.comm.exchange(fine ? packets_of(bodies_->pack(stage)) : std::vector<comm::Packet>{});
        for (const comm::Packet& packet : received)
            if (fine) bodies_->unpack(stage, packet.bytes);
    }
    if (auto agreed = agree_on_error(part, fine); !agreed) return tl::unexpected<Error>(agreed.error());
    return bodies_->finish();
}

}  // namespace meld::sim
