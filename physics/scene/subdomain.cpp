// Packing and unpacking the messages between subdomains.
#include "physics/scene/subdomain.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "physics/solver/block_engine.h"
#include "physics/solver/engine.h"
#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"

namespace meld::physics {

namespace {

// The work of a body in a tick, in shares: a sleeping one is only stored and checked.
// A moving body with a shape takes about as long as four spheres.
constexpr std::uint32_t kShapedWeight = 16, kMovingWeight = 4, kRestingWeight = 1;

// All the data of a body that migrate with it; its shape follows if it is no sphere.
struct PackedBody {
    Place place;
    Orientation orientation;
    BodyVelocity velocity;
    BodyProperties properties;
    Wrench wrench;
    Bodies::FeatureState features;
    double energy_j;
};

struct PackedVelocity {
    BodyId id;
    float linear[3], surface[3];
};

struct PackedFeatureWrench {
    BodyId id;
    Wrench pull;
    float charge_j;
};

struct PackedRest {
    std::uint64_t key;
    std::uint64_t rests;
};

}  // namespace

Subdomain::Subdomain(Scene& scene, OwnerOf owner, int self)
    : scene_(scene), world_(scene.world()), engine_(static_cast<BlockEngine&>(scene.engine())), owner_(std::move(owner)), self_(self) {
    MELD_CHECK(scene.world().settings.engine == EngineKind::Blocks, "only the engine 'blocks' is divided");
    MELD_CHECK(scene.world().composites.empty(), "a divided world has no connections");
    engine_.owns_ = [this](BlockCoordinates block) { return owner_(block) == self_; };
}

bool Subdomain::must_rebuild(double dt_s, int substeps) const { return engine_.must_rebuild({dt_s, substeps}); }

Velocities Subdomain::velocities() const { return velocities_of(world_.bodies); }

void Subdomain::set_velocities(const Velocities& all, double dt_s, int substeps) { engine_.set_velocities(all, {dt_s, substeps}); }

std::vector<int> Subdomain::holders(BlockCoordinates c) const {
    std::vector<int> parts;
    for (int i = 0; i < 27; ++i)
        if (const int owner = owner_({c.x + i % 3 - 1, c.y + i / 3 % 3 - 1, c.z + i / 9 - 1}); owner != self_) parts.push_back(owner);
    std::sort(parts.begin(), parts.end());
    parts.erase(std::unique(parts.begin(), parts.end()), parts.end());
    return parts;
}

Subdomain::Standing Subdomain::standing(BlockCoordinates c) const {
    const int owner = owner_(c);
    bool near_us = owner == self_;
    for (int i = 0; !near_us && i < 27; ++i) near_us = owner_({c.x + i % 3 - 1, c.y + i / 3 % 3 - 1, c.z + i / 9 - 1}) == self_;
    return {c, owner, near_us, holders(c)};
}

double Subdomain::block_m() const { return engine_.next_shape().block_m(); }

std::uint32_t Subdomain::block_with(BodyId body) const {
    const std::uint32_t block = engine_.grid_.block_with(world_.bodies.slot(body));
    MELD_CHECK(block != kNoBlock, "body {} is in no block", body);
    return block;
}

int Subdomain::owner_of(BodyId body) const { return owner_(physics::unpack(engine_.grid_.blocks()[block_with(body)].key)); }

std::vector<std::pair<BlockCoordinates, std::uint32_t>> Subdomain::weights() const {
    const Bodies& bodies = world_.bodies;
    const double block_m = engine_.next_shape().block_m();
    std::vector<std::pair<BlockCoordinates, std::uint32_t>> found;
    for (std::uint32_t slot = 0; slot < bodies.count(); ++slot) {
        if (bodies.properties[slot].flags & (kGhost | kRemoved)) continue;
        const BlockCoordinates block = block_of(bodies.place[slot], block_m);
        if (found.empty() || !(found.back().first == block)) found.emplace_back(block, 0);
        const bool shaped = (bodies.properties[slot].flags & kShaped) != 0;
        found.back().second += bodies.velocity[slot].inverse_mass == 0 ? kRestingWeight : shaped ? kShapedWeight : kMovingWeight;
    }
    return found;
}

Subdomain::Messages Subdomain::pack_bodies(Workers& workers) {
    Bodies& bodies = world_.bodies;
    engine_.count_still_ticks(times_.dt_s);
    engine_.note_stillness();
    engine_.cache_contacts(workers);
    engine_.cached_ = engine_.rebuild_ = true;

    // The blocks of our bodies now, as the coming rebuild will divide space.
    const double block_m = engine_.next_shape().block_m();
    std::vector<std::uint32_t> kept;
    std::map<int, std::vector<std::uint32_t>> leaving;
    std::optional<Standing> at;
    departed_.clear();
    for (std::uint32_t slot = 0; slot < bodies.count(); ++slot) {
        BodyProperties& properties = bodies.properties[slot];
        if (properties.flags & (kGhost | kRemoved)) continue;
        // Bodies of a block are contiguous.
        if (const BlockCoordinates block = block_of(bodies.place[slot], block_m); !at || !(at->block == block)) at = standing(block);
        for (const int part : at->holders) leaving[part].push_back(slot);
        if (at->owner != self_) departed_.emplace_back(properties.id, at->owner);
        if (at->near_us) kept.push_back(slot);
    }
    Messages messages;
    for (const auto& [part, slots] : leaving) {
        std::vector<bool> ids;
        ByteWriter& bytes = messages[part];
        bytes.write(static_cast<std::uint64_t>(slots.size()));
        for (const std::uint32_t slot : slots) {
            const BodyId id = bodies.properties[slot].id;
            if (ids.size() <= id) ids.resize(id + 1u);
            ids[id] = true;
            bytes.write(PackedBody{bodies.place[slot], bodies.orientation[slot], bodies.velocity[slot], bodies.properties[slot],
                                   bodies.wrenches.empty() ? Wrench{} : bodies.wrenches[slot],
                                   bodies.features.empty() ? Bodies::FeatureState{} : bodies.features[slot],
                                   bodies.energy.empty() ? 0 : bodies.energy[slot]});
            if ((bodies.properties[slot].flags & kShaped) != 0) bytes.write(world_.shapes.shape(id));
        }
        engine_.shape_contacts_.pack_kept(ids, bytes);
        for (const CachedContact& contact : engine_.contacts_.cached_of(ids)) bytes.write(contact);
    }
    std::sort(departed_.begin(), departed_.end());
    for (const auto& [id, owner] : departed_) bodies.properties[bodies.slot(id)].flags |= kGhost;
    bodies.permute(kept, workers);
    engine_.forget_blocks();
    return messages;
}

Result<void> Subdomain::unpack_bodies(Bytes bytes) {
    Bodies& bodies = world_.bodies;
    ByteReader in(bytes, "a message between subdomains of the physics");
    const double block_m = engine_.next_shape().block_m();
    for (auto left = in.read<std::uint64_t>(); left > 0; --left) {
        PackedBody body = in.read<PackedBody>();
        if (bodies.has(body.properties.id))
            return fail(fmt::format("body {} came from another part and is here already", body.properties.id),
                        "Give each body to one part");
        const bool ours = owner_(block_of(body.place, block_m)) == self_;
        const BodyId id = body.properties.id;
        world_.shapes.forget(id);
        if ((body.properties.flags & kShaped) != 0)
            if (auto set = world_.shapes.set(id, in.read<BodyShape>()); !set) return set;
        body.properties.flags = static_cast<std::uint8_t>((body.properties.flags & (kFixed | kShaped)) | (ours ? 0 : kGhost));
        bodies.add(body.place, body.orientation, body.velocity, body.properties);
        if (world_.has_features()) bodies.need_features();
        const std::uint32_t slot = bodies.slot(id);
        const Wrench& wrench = body.wrench;
        if (std::any_of(wrench.force, wrench.force + 3, [](float f) { return f != 0; }) ||
            std::any_of(wrench.torque, wrench.torque + 3, [](float f) { return f != 0; }))
            bodies.need_wrenches();
        if (!bodies.wrenches.empty()) bodies.wrenches[slot] = wrench;
        if (world_.has_features()) bodies.features[slot] = body.features, bodies.energy[slot] = body.energy_j;
        bodies.restore_masses(slot);
    }
    engine_.shape_contacts_.unpack_kept(in);
    std::vector<CachedContact> contacts;
    while (!in.done()) contacts.push_back(in.read<CachedContact>());
    engine_.contacts_.add_cached(std::move(contacts));
    return {};
}

void Subdomain::unpacked() { engine_.rebuild_ = true; }

void Subdomain::loaded() {
    if (engine_.last_dt_s_ == 0) return;
    times_ = {engine_.last_dt_s_, static_cast<int>(std::lround(engine_.last_dt_s_ / engine_.last_substep_s_))};
    plan_exchange();
}

std::vector<Stage> Subdomain::stages(double dt_s, int substeps) {
    times_ = {dt_s, substeps};
    return engine_.plan(times_);
}

Result<void> Subdomain::run(const Stage& stage, Workers& workers) {
    if (auto done = engine_.run(stage, times_, workers); !done) return done;
    if (stage.kind == Stage::Kind::Prepare && engine_.rebuilt_in_step_) plan_exchange();
    return {};
}

std::uint8_t Subdomain::bouncing_colours() const { return engine_.bouncing_colours(); }

void Subdomain::plan_exchange() {
    for (auto& lists : touched_) lists.clear();
    border_.clear();
    const auto blocks = engine_.grid_.blocks();
    holders_of_block_.resize(blocks.size());
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        holders_of_block_[b] = holders(physics::unpack(blocks[b].key));
        if (engine_.states_[b].owned)
            for (const int part : holders_of_block_[b]) border_[part].push_back(static_cast<std::uint32_t>(b));
    }
    std::vector<std::uint32_t> block_of(world_.bodies.count());
    for (std::size_t b = 0; b < blocks.size(); ++b)
        std::fill_n(block_of.begin() + blocks[b].first, blocks[b].count, static_cast<std::uint32_t>(b));
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        if (!engine_.states_[b].owned) continue;
        auto& lists = touched_[static_cast<std::size_t>(colour_of(physics::unpack(blocks[b].key)))];
        const auto touch = [&](const auto& batches) {
            for (const auto& batch : batches)
                for (int i = 0; i < kLanes; ++i)
                    for (const std::uint32_t slot : {batch.a[i], batch.b[i]})
                        if (slot < block_of.size())
                            for (const int part : holders_of_block_[block_of[slot]]) lists[part].push_back(slot);
        };
        touch(engine_.contacts_.pairs(b)), touch(engine_.contacts_.obstacle_contacts(b)), touch(engine_.shape_contacts_.batches(b));
    }
    for (auto& lists : touched_)
        for (auto& [part, slots] : lists) {
            std::sort(slots.begin(), slots.end());
            slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
        }
}

Subdomain::Messages Subdomain::pack(const Stage& stage) const {
    MELD_EXPECT(stage.must_exchange(), "nothing is exchanged after stage {}", static_cast<int>(stage.kind));
    Messages messages;
    const Bodies& bodies = world_.bodies;
    if (stage.kind == Stage::Kind::Prepare) {
        for (const auto& [part, blocks] : border_)
            for (const std::uint32_t b : blocks) messages[part].write(PackedRest{engine_.grid_.blocks()[b].key, engine_.states_[b].rests});
        return messages;
    }
    for (const auto& [part, slots] : touched_[static_cast<std::size_t>(stage.colour)]) {
        ByteWriter& bytes = messages[part];
        const bool pulls = stage.kind == Stage::Kind::Actuate;
        bytes.reserve(slots.size() * (pulls ? sizeof(PackedFeatureWrench) : sizeof(PackedVelocity)));
        for (const std::uint32_t slot : slots) {
            const BodyId id = bodies.properties[slot].id;
            if (pulls) {
                bytes.write(PackedFeatureWrench{id, engine_.feature_wrenches_[slot], bodies.features[slot].charge_j});
                continue;
            }
            const BodyVelocity& velocity = bodies.velocity[slot];
            bytes.write(PackedVelocity{id,
                                       {velocity.linear[0], velocity.linear[1], velocity.linear[2]},
                                       {velocity.surface[0], velocity.surface[1], velocity.surface[2]}});
        }
    }
    return messages;
}

void Subdomain::unpack(const Stage& stage, Bytes bytes) {
    Bodies& bodies = world_.bodies;
    ByteReader in(bytes, "a message between subdomains of the physics");
    while (!in.done()) {
        if (stage.kind == Stage::Kind::Prepare) {
            const auto rest = in.read<PackedRest>();
            if (const std::uint32_t block = engine_.grid_.find(rest.key); block != kNoBlock) engine_.states_[block].rests = rest.rests != 0;
        } else if (stage.kind == Stage::Kind::Actuate) {
            const auto pull = in.read<PackedFeatureWrench>();
            if (!bodies.has(pull.id)) continue;
            engine_.feature_wrenches_[bodies.slot(pull.id)] = pull.pull;
            bodies.features[bodies.slot(pull.id)].charge_j = pull.charge_j;
        } else {
            const auto moving = in.read<PackedVelocity>();
            if (!bodies.has(moving.id)) continue;
            BodyVelocity& velocity = bodies.velocity[bodies.slot(moving.id)];
            std::copy_n(moving.linear, 3, velocity.linear);
            std::copy_n(moving.surface, 3, velocity.surface);
        }
    }
}

StepReport Subdomain::finish() {
    world_.last_step_s = times_.dt_s;
    scene_.forget_contacts();
    StepReport report = engine_.report();
    report.bodies = scene_.body_count();
    report.tick = ++world_.tick;
    return report;
}

Subdomain::Messages Subdomain::pack_sums(std::span<const ExactSum> of_slot) const {
    Messages messages;
    for (std::size_t b = 0; b < engine_.grid_.blocks().size(); ++b) {
        if (engine_.states_[b].owned) continue;
        const Block& block = engine_.grid_.blocks()[b];
        ByteWriter& bytes = messages[owner_(physics::unpack(block.key))];
        for (std::uint32_t slot = block.first; slot < block.first + block.count; ++slot)
            if (!(of_slot[slot] == ExactSum{})) bytes.write(world_.bodies.properties[slot].id), bytes.write(of_slot[slot]);
    }
    return messages;
}

void Subdomain::unpack_sums(std::span<ExactSum> of_slot, Bytes bytes) const {
    ByteReader in(bytes, "a message between subdomains of the physics");
    while (!in.done()) {
        const auto id = in.read<BodyId>();
        of_slot[world_.bodies.slot(id)].add(in.read<ExactSum>());
    }
}

std::vector<BlockCoordinates> Subdomain::border_blocks() const {
    std::vector<std::uint64_t> keys;
    for (const auto& [part, blocks] : border_)
        for (const std::uint32_t b : blocks) keys.push_back(engine_.grid_.blocks()[b].key);
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    std::vector<BlockCoordinates> coordinates;
    for (const std::uint64_t key : keys) coordinates.push_back(physics::unpack(key));
    return coordinates;
}

}  // namespace meld::physics
