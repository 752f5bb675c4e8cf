// Packing and unpacking the messages between subdomains.
#include "physics/scene/subdomain.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <numeric>
#include <optional>

#include "physics/scene/packed_body.h"
#include "physics/solver/block_engine.h"
#include "physics/solver/engine.h"
#include "physics/solver/saved_bodies.h"
#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"

namespace meld::physics {

namespace {

// The work of a body in a tick, in shares: a sleeping one is only stored and checked.
// A moving body with a shape takes about as long as four spheres.
constexpr std::uint32_t kShapedWeight = 16, kMovingWeight = 4, kRestingWeight = 1;

struct PackedFeatureWrench {
    BodyId id;
    Wrench pull;
    float charge_j;
};

struct PackedRest {
    std::uint64_t key;
    // kRests; kJoined: it is for what all say of blocks with joints.
    std::uint64_t flags;
};
constexpr std::uint64_t kRests = 1, kJoined = 2;

// A block of a snapshot of which some bodies go where joints hold them.
struct PackedHome {
    Home home;
    std::uint64_t asleep;
};

void unite(std::vector<int>& to, const std::vector<int>& more) {
    std::vector<int> all;
    std::ranges::set_union(to, more, std::back_inserter(all));
    to = std::move(all);
}
bool contains(const std::vector<int>& parts, int part) { return std::ranges::binary_search(parts, part); }

}  // namespace

Subdomain::Subdomain(Scene& scene, OwnerOf owner, int self, int parts)
    : scene_(scene),
      world_(scene.world()),
      engine_(static_cast<BlockEngine&>(scene.engine())),
      owner_(std::move(owner)),
      self_(self),
      parts_(parts) {
    MELD_EXPECT(self >= 0 && self < parts, "subdomain {} of {}", self, parts);
    MELD_CHECK(scene.world().settings.engine == EngineKind::Blocks, "only the engine 'blocks' is divided");
    MELD_CHECK(scene.world().composites.all().empty(), "a world is divided before its first step");
    engine_.owns_ = [this](BlockCoordinates block) { return owner_(block) == self_; };
    engine_.divided_joints_ = !world_.joints.empty();
    world_.loads.note_pushes();
    if (!scene_.has_all_joined()) return;
    joined_holders_ = held_by_all({});
    for (auto& [body, others] : joined_holders_) std::erase(others, self_);
}

bool Subdomain::must_rebuild(double dt_s, int substeps) const { return engine_.must_rebuild({dt_s, substeps}); }

Velocities Subdomain::velocities() const { return velocities_of(world_.bodies); }

void Subdomain::set_velocities(const Velocities& all, double dt_s, int substeps) { engine_.set_velocities(all, {dt_s, substeps}); }

std::vector<int> Subdomain::holding(BlockCoordinates c) const {
    std::vector<int> parts;
    for (int i = 0; i < 27; ++i) parts.push_back(owner_({c.x + i % 3 - 1, c.y + i / 3 % 3 - 1, c.z + i / 9 - 1}));
    std::sort(parts.begin(), parts.end());
    parts.erase(std::unique(parts.begin(), parts.end()), parts.end());
    return parts;
}

std::vector<int> Subdomain::holders(BlockCoordinates c) const {
    std::vector<int> parts = holding(c);
    std::erase(parts, self_);
    return parts;
}

const std::vector<int>& Subdomain::holders_of(BodyId body) const {
    const auto joined = joined_holders_.find(body);
    return joined != joined_holders_.end() ? joined->second : holders_of_block_[block_with(body)];
}

Subdomain::Holding Subdomain::holding_joined(const Joints::Groups& groups, Pairs also,
                                             const std::function<BlockCoordinates(BodyId)>& block_of) const {
    if (scene_.has_all_joined()) return held_by_all(also);
    std::unordered_map<std::uint64_t, std::vector<int>> of_block;
    Holding all;
    const auto hold_together = [&](std::vector<BodyId> bodies) {
        std::ranges::sort(bodies);
        bodies.erase(std::unique(bodies.begin(), bodies.end()), bodies.end());
        std::vector<int> parts;
        for (const BodyId body : bodies) {
            const BlockCoordinates block = block_of(body);
            const auto [found, is_new] = of_block.try_emplace(physics::pack(block));
            if (is_new) found->second = holding(block);
            if (!std::ranges::includes(parts, found->second)) unite(parts, found->second);
        }
        for (const BodyId body : bodies) unite(all[body], parts);
    };
    for (const auto& [lowest, joints] : groups) {
        std::vector<BodyId> bodies;
        for (const std::uint32_t joint : joints)
            for (const BodyId body : {world_.joints.all()[joint].first, world_.joints.all()[joint].second}) bodies.push_back(body);
        hold_together(std::move(bodies));
    }
    for (const Composite& composite : world_.composites.all()) {
        std::vector<BodyId> bodies;
        for (const Composites::Member& member : world_.composites.members(composite)) bodies.push_back(member.id);
        hold_together(std::move(bodies));
    }
    for (const auto& [one, other] : also) hold_together({one, other});
    return all;
}

std::vector<int> Subdomain::everybody() const {
    std::vector<int> parts(static_cast<std::size_t>(parts_));
    std::iota(parts.begin(), parts.end(), 0);
    return parts;
}

Subdomain::Holding Subdomain::held_by_all(Pairs also) const {
    const std::vector<int> parts = everybody();
    Holding all;
    for (const Joint& joint : world_.joints.all()) all[joint.first] = all[joint.second] = parts;
    for (const Composites::Member& member : world_.composites.members()) all[member.id] = parts;
    for (const auto& [one, other] : also) all[one] = all[other] = parts;
    return all;
}

void Subdomain::keep_joints(const std::vector<bool>& kept) {
    for (std::size_t j = 0; j < kept.size(); ++j)
        if (const Joint& joint = world_.joints.all()[j]; !kept[j]) world_.composites.joined().remove(joint.first, joint.second);
    world_.joints.keep(kept);
}

// Who has the lowest body of a mechanism gives its joints to those that come near it; all others that have it have the same bits of it.
std::map<int, std::vector<Joint>> Subdomain::hand_over_joints(const Joints::Groups& groups, const Holding& holding) {
    std::map<int, std::vector<Joint>> sent;
    if (scene_.has_all_joined()) return sent;
    std::vector<bool> kept(world_.joints.all().size());
    for (const auto& [lowest, joints] : groups) {
        const std::vector<int>& parts = holding.at(lowest);
        const bool stays = contains(parts, self_), ours = (world_.bodies.properties[world_.bodies.slot(lowest)].flags & kGhost) == 0;
        for (const std::uint32_t joint : joints) kept[joint] = stays;
        if (!ours || all_have_joints_) continue;
        const std::vector<int>& had = holders_of(lowest);
        for (const int part : parts)
            if (part != self_ && !contains(had, part))
                for (const std::uint32_t joint : joints) sent[part].push_back(world_.joints.all()[joint]);
    }
    all_have_joints_ = false;
    keep_joints(kept);
    return sent;
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
        const std::uint32_t mover = world_.composites.mover_of(bodies.properties[slot].id);
        const bool rests = mover == kNoComposite ? bodies.velocity[slot].inverse_mass == 0 : world_.composites.all()[mover].asleep != 0;
        found.back().second += rests ? kRestingWeight : shaped ? kShapedWeight : kMovingWeight;
    }
    return found;
}

Subdomain::Messages Subdomain::pack_bodies(Workers& workers) {
    Bodies& bodies = world_.bodies;
    if (!std::exchange(counted_, false)) engine_.count_still_ticks(times_.dt_s);
    engine_.note_stillness();
    world_.events.clear();
    engine_.cache_contacts(workers);
    engine_.cached_ = engine_.rebuild_ = true;

    // The blocks of our bodies now, as the coming rebuild will divide space.
    const double block_m = engine_.next_shape().block_m();
    std::vector<std::uint32_t> kept;
    // By destination: the slots of bodies, and whether their contacts may be found there.
    std::map<int, std::vector<std::pair<std::uint32_t, bool>>> leaving;
    std::optional<Standing> at;
    Holding holding;
    std::map<int, std::vector<Joint>> joints;
    std::map<int, std::vector<std::uint32_t>> composites;
    std::vector<bool> kept_composites;
    if (has_joined()) {
        // Where all have all, bodies with new joints are perhaps still on their way here, and groups do not matter.
        const Joints::Groups groups = scene_.has_all_joined() ? Joints::Groups() : world_.joints.groups(world_.movers());
        holding = holding_joined(groups, {}, [&](BodyId body) { return block_of(bodies.place[bodies.slot(body)], block_m); });
        joints = hand_over_joints(groups, holding);
        composites = hand_over_composites(holding, kept_composites);
    }
    departed_.clear();
    for (std::uint32_t slot = 0; slot < bodies.count(); ++slot) {
        BodyProperties& properties = bodies.properties[slot];
        if (properties.flags & (kGhost | kRemoved)) continue;
        // Bodies of a block are contiguous.
        if (const BlockCoordinates block = block_of(bodies.place[slot], block_m); !at || !(at->block == block)) at = standing(block);
        for (const int part : at->holders) leaving[part].emplace_back(slot, true);
        if (at->owner != self_) departed_.emplace_back(properties.id, at->owner);
        const auto joined = holding.empty() ? holding.end() : holding.find(properties.id);
        const bool is_joined = joined != holding.end();
        for (const int part : is_joined ? joined->second : std::vector<int>())
            if (part != self_ && !contains(at->holders, part)) leaving[part].emplace_back(slot, false);
        if (at->near_us || (is_joined && contains(joined->second, self_))) kept.push_back(slot);
    }
    Messages messages;
    for (const auto& [part, slots] : leaving) {
        std::vector<bool> ids;
        ByteWriter& bytes = messages[part];
        bytes.write(static_cast<std::uint64_t>(slots.size()));
        for (const auto& [slot, is_near] : slots) {
            const BodyId id = bodies.properties[slot].id;
            if (ids.size() <= id) ids.resize(id + 1u);
            ids[id] = is_near;
            pack_body(world_, slot, bytes);
        }
        const auto with_joints = joints.find(part);
        bytes.write_count(with_joints == joints.end() ? 0 : with_joints->second.size());
        if (with_joints != joints.end())
            for (const Joint& joint : with_joints->second) bytes.write(joint);
        if (shares_composites()) pack_composites(composites[part], bytes);
        engine_.shape_contacts_.pack_kept(ids, bytes);
        for (const CachedContact& contact : engine_.contacts_.cached_of(ids)) bytes.write(contact);
    }
    drop_composites(kept_composites);
    std::sort(departed_.begin(), departed_.end());
    for (const auto& [id, owner] : departed_) bodies.properties[bodies.slot(id)].flags |= kGhost;
    bodies.permute(kept, workers);
    engine_.forget_blocks();
    return messages;
}

Result<void> Subdomain::unpack_bodies(Bytes bytes) {
    ByteReader in(bytes, "a message between subdomains of the physics");
    const double block_m = engine_.next_shape().block_m();
    for (auto left = in.read<std::uint64_t>(); left > 0; --left) {
        auto added = unpack_body(world_, in, [&](const Place& place) { return owner_(block_of(place, block_m)) == self_; });
        if (!added) return added;
    }
    std::vector<Joint> joints(in.read_count(sizeof(Joint)));
    for (Joint& joint : joints) {
        joint = in.read<Joint>();
        world_.composites.joined().add(joint.first, joint.second);
    }
    world_.joints.add_all(joints);
    if (shares_composites()) unpack_composites(in);
    engine_.shape_contacts_.unpack_kept(in);
    std::vector<CachedContact> contacts;
    while (!in.done()) contacts.push_back(in.read<CachedContact>());
    engine_.contacts_.add_cached(std::move(contacts));
    return {};
}

void Subdomain::unpacked() {
    engine_.rebuild_ = true;
    if (!shares_composites()) return;
    world_.composites.arrange(world_.bodies);
    Loads::OfComposites of = std::exchange(of_composites_, {});
    if (world_.loads.wanted()) world_.loads.put_in(std::move(of), world_.composites);
}

void Subdomain::loaded() {
    const Holding loaded = std::exchange(loading_joined_, {});
    if (engine_.last_dt_s_ != 0) {
        times_ = {engine_.last_dt_s_, static_cast<int>(std::lround(engine_.last_dt_s_ / engine_.last_substep_s_))};
        plan_exchange();
    }
    if (!scene_.has_all_joined()) return;
    // Until the next rebuild all have also those that came with these for other reasons.
    for (const auto& [body, parts] : loaded)
        if (const auto [at, is_new] = joined_holders_.try_emplace(body, parts); is_new) std::erase(at->second, self_);
}

bool Subdomain::has_joined() const { return !world_.joints.empty() || !world_.composites.all().empty(); }

std::vector<Subdomain::JoinedBody> Subdomain::joined_bodies(Pairs also) const {
    std::unordered_map<std::uint32_t, Home> homes;
    for (const BlockEngine::LoadedBlock& block : engine_.loading_.blocks)
        for (std::uint32_t i = 0; i < block.count; ++i) homes.emplace(block.first + i, block.key);
    std::vector<JoinedBody> ours;
    const auto add = [&](BodyId body) {
        if (!world_.bodies.has(body)) return;
        const std::uint32_t slot = world_.bodies.slot(body);
        const std::uint8_t flags = world_.bodies.properties[slot].flags;
        if ((flags & kGhost) != 0) return;
        const auto home = homes.find(slot);
        ours.push_back({body, (flags & kFixed) != 0 ? 1u : 0u, home == homes.end() ? Home{0} : home->second});
    };
    for (const Joint& joint : world_.joints.all()) add(joint.first), add(joint.second);
    for (const auto& [one, other] : also) add(one), add(other);
    if (engine_.composites_fine_)
        for (const Composites::Member& member : world_.composites.members()) add(member.id);
    std::ranges::sort(ours, {}, &JoinedBody::id);
    const auto twice = std::ranges::unique(ours, {}, &JoinedBody::id);
    ours.erase(twice.begin(), twice.end());
    return ours;
}

// Before the first step no body is in a block, and all have all.
void Subdomain::learn_joined(std::span<const JoinedBody> all, Pairs also) {
    std::unordered_map<BodyId, const JoinedBody*> known;
    for (const JoinedBody& body : all) known.emplace(body.id, &body);
    // Bodies that the snapshot has not are found by Scene::loaded.
    std::vector<bool> kept(world_.joints.all().size());
    for (std::size_t j = 0; j < kept.size(); ++j)
        kept[j] = known.contains(world_.joints.all()[j].first) && known.contains(world_.joints.all()[j].second);
    const auto unknown = [&](const Composites::Member& member) { return !known.contains(member.id); };
    if (std::ranges::find(kept, false) != kept.end() || !engine_.composites_fine_ ||
        std::ranges::any_of(world_.composites.members(), unknown))
        return;
    std::vector<std::pair<BodyId, BodyId>> pairs;
    for (const auto& pair : also)
        if (known.contains(pair.first) && known.contains(pair.second)) pairs.push_back(pair);
    engine_.divided_joints_ = !world_.joints.empty();
    for (const Joint& joint : world_.joints.all()) world_.composites.joined().add(joint.first, joint.second);
    if (engine_.last_dt_s_ == 0 || scene_.has_all_joined()) {
        for (const JoinedBody& body : all) loading_joined_[body.id] = everybody();
        return;
    }
    all_have_joints_ = false;
    const Joints::Groups groups = world_.joints.groups([&](BodyId body) { return known.at(body)->fixed == 0 ? body : kMaxBodies; });
    loading_joined_ = holding_joined(groups, pairs, [&](BodyId body) { return physics::unpack(known.at(body)->home); });
    for (const auto& [lowest, joints] : groups)
        for (const std::uint32_t joint : joints) kept[joint] = contains(loading_joined_.at(lowest), self_);
    keep_joints(kept);
    std::vector<bool> here;
    for (const Composite& composite : world_.composites.all())
        here.push_back(contains(loading_joined_.at(world_.composites.members(composite).front().id), self_));
    world_.composites.keep(here);
}

Subdomain::Messages Subdomain::pack_joined() const {
    Messages messages;
    const auto pack_some = [&](const PackedHome& home, std::uint32_t first, std::uint32_t count, const std::vector<int>& holders) {
        std::map<int, std::vector<std::uint32_t>> leaving;
        for (std::uint32_t slot = first; slot < first + count; ++slot) {
            const BodyProperties& what = world_.bodies.properties[slot];
            const auto joined = loading_joined_.find(what.id);
            if (joined == loading_joined_.end() || (what.flags & kGhost) != 0) continue;
            for (const int part : joined->second)
                if (part != self_ && !contains(holders, part)) leaving[part].push_back(slot);
        }
        for (const auto& [part, slots] : leaving) {
            messages[part].write(home);
            save_bodies(world_, slots, messages[part]);
        }
    };
    if (engine_.last_dt_s_ == 0) pack_some({}, 0, static_cast<std::uint32_t>(world_.bodies.count()), {});
    for (const BlockEngine::LoadedBlock& block : engine_.loading_.blocks)
        if (block.state.owned) pack_some({block.key, block.state.asleep}, block.first, block.count, holders(physics::unpack(block.key)));
    return messages;
}

Result<void> Subdomain::unpack_joined(Bytes bytes) {
    ByteReader in(bytes, "bodies of a snapshot that joints hold");
    while (!in.done()) {
        const auto home = in.read<PackedHome>();
        const auto first = static_cast<std::uint32_t>(world_.bodies.count());
        if (auto added = load_bodies(world_, Holds::Ghosts, in); !added) return added;
        if (engine_.last_dt_s_ == 0) continue;
        BlockEngine::LoadedBlock& block = engine_.loading_.blocks.emplace_back();
        block.key = home.home, block.first = first, block.count = static_cast<std::uint32_t>(world_.bodies.count()) - first;
        block.state.asleep = block.state.rests = home.asleep != 0;
        block.state.owned = false;
    }
    return {};
}

std::vector<Stage> Subdomain::stages(double dt_s, int substeps) {
    times_ = {dt_s, substeps};
    if (scene_.has_all_joined()) engine_.divided_joints_ = !world_.joints.empty();
    return engine_.plan(times_);
}

Result<void> Subdomain::run(const Stage& stage, Workers& workers) {
    using Kind = Stage::Kind;
    if (stage.kind == Kind::FindResting) add_copies();
    if (stage.kind == Kind::BounceComposites) begin_round(stage.round);
    if (auto done = engine_.run(stage, times_, workers); !done) return done;
    if (stage.kind == Kind::Prepare && engine_.rebuilt_in_step_) plan_exchange();
    const bool links = engine_.divided_joints_ || engine_.shares_composites();
    if (links && stage.kind == Kind::Prepare) engine_.say_links_and_stays();
    if (links && stage.kind == Kind::FindResting) engine_.say_rests();
    if (stage.kind == Kind::ShareLoads)
        for (Loads::Noted& push : world_.loads.noted()) push.block = engine_.grid_.blocks()[push.block].key;
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
    joined_holders_.clear();
    std::vector<const std::vector<int>*> of_joined;
    if (has_joined()) {
        joined_holders_ = holding_joined(world_.joints.groups(world_.movers()), {},
                                         [&](BodyId body) { return physics::unpack(blocks[block_with(body)].key); });
        of_joined.resize(world_.bodies.count());
        for (auto& [body, parts] : joined_holders_) {
            std::erase(parts, self_);
            of_joined[world_.bodies.slot(body)] = &parts;
        }
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
                    for (const std::uint32_t slot : {batch.a[i], batch.b[i]}) {
                        if (slot >= block_of.size()) continue;
                        const std::vector<int>* joined = of_joined.empty() ? nullptr : of_joined[slot];
                        for (const int part : joined != nullptr ? *joined : holders_of_block_[block_of[slot]]) lists[part].push_back(slot);
                    }
        };
        touch(engine_.contacts_.pairs(b)), touch(engine_.contacts_.obstacle_contacts(b)), touch(engine_.shape_contacts_.batches(b));
    }
    for (auto& lists : touched_)
        for (auto& [part, slots] : lists) {
            std::sort(slots.begin(), slots.end());
            slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
        }
    plan_copies();
}

Subdomain::Messages Subdomain::pack(const Stage& stage) const {
    MELD_EXPECT(stage.must_exchange(), "nothing is exchanged after stage {}", static_cast<int>(stage.kind));
    Messages messages;
    const Bodies& bodies = world_.bodies;
    const auto blocks = engine_.grid_.blocks();
    switch (stage.kind) {
        case Stage::Kind::Prepare:
            pack_links(messages);
            return messages;
        case Stage::Kind::BounceComposites:
            pack_bounces(stage, messages);
            return messages;
        case Stage::Kind::ShareLoads:
            pack_loads(messages);
            return messages;
        default:
            break;
    }
    if (stage.kind == Stage::Kind::FindResting) {
        for (const auto& [part, list] : border_)
            for (const std::uint32_t b : list) messages[part].write(PackedRest{blocks[b].key, engine_.states_[b].rests ? kRests : 0});
        for (std::uint32_t b = 0; b < engine_.has_joined_.size(); ++b)
            for (int part = 0; part < parts_; ++part)
                if (part != self_ && engine_.has_joined_[b] != 0 && engine_.states_[b].owned)
                    messages[part].write(PackedRest{blocks[b].key, kJoined | (engine_.states_[b].rests ? kRests : 0)});
        return messages;
    }
    if (stage.ends_sweep() && engine_.shares_composites()) pack_copies(messages);
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
            // Composites move their members.
            if ((bodies.properties[slot].flags & kMember) != 0) continue;
            bytes.write(packed_velocity(bodies, slot));
        }
    }
    return messages;
}

void Subdomain::unpack(const Stage& stage, Bytes bytes) {
    Bodies& bodies = world_.bodies;
    ByteReader in(bytes, "a message between subdomains of the physics");
    if (stage.kind == Stage::Kind::Prepare) return unpack_links(in);
    if (stage.kind == Stage::Kind::ShareLoads) return unpack_loads(in);
    if (stage.kind == Stage::Kind::BounceComposites) unpack_bounces(in);
    if (stage.ends_sweep() && engine_.shares_composites()) unpack_copies(in);
    while (!in.done()) {
        if (stage.kind == Stage::Kind::FindResting) {
            const auto rest = in.read<PackedRest>();
            const bool rests = (rest.flags & kRests) != 0;
            if ((rest.flags & kJoined) == 0) {
                if (const std::uint32_t block = engine_.grid_.find(rest.key); block != kNoBlock) engine_.states_[block].rests = rests;
            } else if (!rests) {
                engine_.all_links_.say_no(rest.key);
            }
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
