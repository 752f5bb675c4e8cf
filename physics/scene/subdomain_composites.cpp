// Composites that several subdomains have: who gets which bodies, copies and collisions.
#include <algorithm>
#include <iterator>
#include <set>
#include <unordered_map>
#include <utility>

#include "physics/scene/packed_body.h"
#include "physics/scene/subdomain.h"
#include "physics/solver/block_engine.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

// A block with joints or members of composites: one that it is linked with, and whether it does not stay.
struct PackedLink {
    std::uint64_t key, linked;
    std::uint64_t moves;
};

struct PackedMotion {
    BodyId lowest;
    std::uint32_t zero;
    Vec3 velocity_m_s, spin_rad_s;
};

bool is_in(const std::vector<int>& parts, int part) { return std::ranges::binary_search(parts, part); }

}  // namespace

bool Subdomain::shares_composites() const { return engine_.shares_composites(); }

bool Subdomain::recomposes() {
    changes_here_ = world_.composites.find_changes([&](BodyId body) { return scene_.has_all_joined() || world_.bodies.has(body); });
    return changes_here_;
}

std::vector<int> Subdomain::had(BodyId body) const {
    if (const auto joined = joined_holders_.find(body); joined != joined_holders_.end()) return joined->second;
    const std::uint32_t block = engine_.grid_.block_with(world_.bodies.slot(body));
    return block < holders_of_block_.size() ? holders_of_block_[block] : std::vector<int>();
}

ByteWriter Subdomain::members_held() const {
    ByteWriter out;
    for (const std::vector<BodyId>& group : world_.composites.new_groups()) {
        std::set<int> parts{self_};
        for (const BodyId body : group) {
            if (!world_.bodies.has(body) || (world_.bodies.properties[world_.bodies.slot(body)].flags & kGhost) != 0) continue;
            const std::vector<int> others = had(body);
            parts.insert(others.begin(), others.end());
        }
        out.write(group.front());
        out.write_count(parts.size());
        for (const int part : parts) out.write(part);
    }
    return out;
}

Subdomain::Messages Subdomain::pack_members(const OfParts& held) {
    std::unordered_map<BodyId, std::set<int>> parts_of_group;
    for (const std::vector<std::byte>& from : held)
        for (ByteReader in(from, "who has the bodies of composites"); !in.done();) {
            std::set<int>& parts = parts_of_group[in.read<BodyId>()];
            for (auto left = in.read_count(sizeof(int)); left > 0; --left) parts.insert(in.read<int>());
        }
    Messages messages;
    for (const std::vector<BodyId>& group : world_.composites.new_groups()) {
        const std::set<int>& some = parts_of_group.at(group.front());
        std::vector<int> others = scene_.has_all_joined() ? everybody() : std::vector<int>(some.begin(), some.end());
        std::erase(others, self_);
        for (const BodyId body : group) {
            if (world_.bodies.has(body) && (world_.bodies.properties[world_.bodies.slot(body)].flags & kGhost) == 0) {
                const std::vector<int> have_it = had(body);
                for (const int part : others)
                    if (!is_in(have_it, part)) pack_body(world_, world_.bodies.slot(body), messages[part]);
            }
            joined_holders_[body] = others;
        }
    }
    return messages;
}

Result<void> Subdomain::unpack_members(Bytes bytes) {
    ByteReader in(bytes, "bodies of composites");
    while (!in.done())
        if (auto added = unpack_body(world_, in, [](const Place&) { return false; }); !added) return added;
    return {};
}

// As an undivided step begins.
void Subdomain::recompose(Workers& workers) {
    engine_.count_still_ticks(times_.dt_s);
    counted_ = true;
    if (std::exchange(changes_here_, false)) world_.composites.make_changes(world_.bodies, world_.shapes);
    world_.composites.set_all_velocities(world_.bodies, workers);
    world_.joints.recomposed();
    engine_.recomposed_before_ = true;
}

// Who has the lowest body of a composite gives what is known of it to those that come near it.
std::map<int, std::vector<std::uint32_t>> Subdomain::hand_over_composites(const Holding& holding, std::vector<bool>& kept) const {
    std::map<int, std::vector<std::uint32_t>> sent;
    const auto all = world_.composites.all();
    for (std::uint32_t c = 0; c < all.size(); ++c) {
        const BodyId lowest = world_.composites.members(all[c]).front().id;
        const std::vector<int>& parts = holding.at(lowest);
        kept.push_back(is_in(parts, self_));
        if ((world_.bodies.properties[world_.bodies.slot(lowest)].flags & kGhost) != 0) continue;
        const std::vector<int> have_it = had(lowest);
        for (const int part : parts)
            if (part != self_ && !is_in(have_it, part)) sent[part].push_back(c);
    }
    return sent;
}

void Subdomain::pack_composites(const std::vector<std::uint32_t>& composites, ByteWriter& out) const {
    out.write_count(composites.size());
    for (const std::uint32_t c : composites) {
        const Composite& composite = world_.composites.all()[c];
        world_.composites.write(composite, out);
        world_.loads.write(world_.composites, composite, out);
    }
}

void Subdomain::unpack_composites(ByteReader& in) {
    for (auto left = in.read_count(sizeof(Composite)); left > 0; --left) {
        MELD_CHECK(world_.composites.read_one(in), "a composite from another part is not whole");
        const BodyId lowest = world_.composites.members(world_.composites.all().back()).front().id;
        of_composites_[lowest] = Loads::read_one(in);
    }
}

void Subdomain::drop_composites(const std::vector<bool>& kept) {
    if (kept.empty()) return;
    of_composites_ = world_.loads.take_out(world_.composites);
    world_.composites.keep(kept);
}

void Subdomain::plan_copies() {
    copies_to_.clear(), copies_from_.clear(), names_elsewhere_.clear(), copies_elsewhere_.clear();
    copies_are_new_ = true;
    for (const PlaceOfCopy& copy : engine_.rows_.copies_here()) {
        const Composite& composite = world_.composites.all()[copy.composite];
        for (const int part : joined_holders_.at(world_.composites.members(composite).front().id)) copies_to_[part].push_back(copy);
    }
}

void Subdomain::add_copies() {
    if (!std::exchange(copies_are_new_, false)) return;
    copies_elsewhere_ =
        engine_.rows_.add_copies(names_elsewhere_, engine_.shape_contacts_, world_.bodies, world_.composites, engine_.grid_.blocks());
}

void Subdomain::pack_links(Messages& messages) const {
    const auto blocks = engine_.grid_.blocks();
    std::vector<PackedLink> links;
    for (std::uint32_t b = 0; b < engine_.has_joined_.size(); ++b)
        if (engine_.has_joined_[b] != 0)
            links.push_back({blocks[b].key, blocks[engine_.linked_[b]].key, engine_.states_[b].owned && !engine_.states_[b].stays});
    for (int part = 0; part < parts_; ++part) {
        const auto copies = copies_to_.find(part);
        const bool has_copies = copies_are_new_ && copies != copies_to_.end();
        if (part == self_ || (links.empty() && !has_copies)) continue;
        ByteWriter& out = messages[part];
        out.write_count(links.size());
        for (const PackedLink& link : links) out.write(link);
        out.write(self_);
        out.write_count(has_copies ? copies->second.size() : 0);
        if (!has_copies) continue;
        for (const PlaceOfCopy& copy : copies->second) out.write(engine_.rows_.name_of(copy, blocks, world_.composites));
    }
}

void Subdomain::unpack_links(ByteReader& in) {
    for (auto left = in.read_count(sizeof(PackedLink)); left > 0; --left) {
        const auto link = in.read<PackedLink>();
        engine_.all_links_.link(link.linked, link.key);
        if (link.moves != 0) engine_.all_links_.say_no(link.key);
    }
    const int from = in.read<int>();
    const std::size_t count = in.read_count(sizeof(CopyName));
    if (count > 0) copies_from_[from] = {names_elsewhere_.size(), count};
    for (std::size_t i = 0; i < count; ++i) names_elsewhere_.push_back(in.read<CopyName>());
}

// Those that sleep do so everywhere.
void Subdomain::pack_copies(Messages& messages) const {
    for (const auto& [part, slots] : touched_[kColours - 1]) messages[part].write(self_);
    for (const auto& [part, copies] : copies_to_) {
        ByteWriter& out = messages[part];
        if (out.empty()) out.write(self_);
        for (const PlaceOfCopy& copy : copies)
            if (world_.composites.all()[copy.composite].moves_freely()) out.write(engine_.rows_.velocity_of(copy, world_.bodies));
    }
}

void Subdomain::unpack_copies(ByteReader& in) {
    const auto from = copies_from_.find(in.read<int>());
    if (from == copies_from_.end()) return;
    for (std::size_t i = 0; i < from->second.second; ++i) {
        const PlaceOfCopy& copy = copies_elsewhere_[from->second.first + i];
        if (world_.composites.all()[copy.composite].moves_freely())
            engine_.rows_.set_velocity(copy, in.read<CopyVelocity>(), world_.bodies);
    }
}

ByteWriter Subdomain::bouncing_blocks() const {
    ByteWriter out;
    for (const std::uint32_t block : engine_.blocks_of_composite_bounces()) out.write(engine_.grid_.blocks()[block].key);
    return out;
}

void Subdomain::agree_on_bounces(const OfParts& of_parts) {
    std::vector<std::pair<std::uint64_t, int>> blocks;
    for (std::size_t part = 0; part < of_parts.size(); ++part)
        for (ByteReader in(of_parts[part], "where composites bounce"); !in.done();)
            blocks.emplace_back(in.read<std::uint64_t>(), static_cast<int>(part));
    std::ranges::sort(blocks);
    rounds_.clear();
    for (const auto& [key, part] : blocks) {
        if (rounds_.empty() || rounds_.back().part != part) rounds_.push_back({part, {}});
        rounds_.back().blocks.push_back(key);
    }
}

void Subdomain::begin_round(int round) {
    engine_.composites_bounce_now_.clear();
    const Round& now = rounds_[static_cast<std::size_t>(round)];
    if (now.part != self_) return;
    for (const std::uint64_t key : now.blocks) engine_.composites_bounce_now_.push_back(engine_.grid_.find(key));
}

// Of all that a block of this round may have changed.
void Subdomain::pack_bounces(const Stage& stage, Messages& messages) const {
    if (rounds_[static_cast<std::size_t>(stage.round)].part != self_) return;
    std::set<std::uint32_t> composites, slots;
    const auto note = [&](const auto& batches) {
        for (const auto& batch : batches)
            for (int i = 0; i < kLanes; ++i)
                for (const std::uint32_t slot : {batch.a[i], batch.b[i]}) {
                    if (slot >= world_.bodies.count()) continue;
                    const std::uint32_t mover = world_.composites.mover_of(world_.bodies.properties[slot].id);
                    if (mover != kNoComposite)
                        composites.insert(mover);
                    else
                        slots.insert(slot);
                }
    };
    for (const std::uint32_t block : engine_.composites_bounce_now_) {
        note(engine_.contacts_.joint_pairs(block)), note(engine_.contacts_.mixed_pairs(block));
        note(engine_.contacts_.mixed_obstacles(block)), note(engine_.shape_contacts_.batches(block));
    }
    std::map<int, std::vector<PackedMotion>> motions;
    std::map<int, std::vector<std::uint32_t>> bodies;
    for (const std::uint32_t c : composites) {
        const Composite& composite = world_.composites.all()[c];
        const BodyId lowest = world_.composites.members(composite).front().id;
        for (const int part : joined_holders_.at(lowest))
            motions[part].push_back({lowest, 0, composite.motion.velocity_m_s, composite.motion.spin_rad_s});
    }
    for (const std::uint32_t slot : slots)
        for (const int part : holders_of(world_.bodies.properties[slot].id)) bodies[part].push_back(slot);
    for (int part = 0; part < parts_; ++part) {
        if (motions[part].empty() && bodies[part].empty()) continue;
        messages[part].write_count(motions[part].size());
        for (const PackedMotion& motion : motions[part]) messages[part].write(motion);
        for (const std::uint32_t slot : bodies[part]) messages[part].write(packed_velocity(world_.bodies, slot));
    }
}

void Subdomain::unpack_bounces(ByteReader& in) {
    for (auto left = in.read_count(sizeof(PackedMotion)); left > 0; --left) {
        const auto bounced = in.read<PackedMotion>();
        const std::uint32_t composite = world_.composites.composite_of(bounced.lowest);
        MELD_CHECK(composite != kNoComposite, "a composite with body {} bounces elsewhere", bounced.lowest);
        CompositeMotion& motion = world_.composites.all()[composite].motion;
        motion.velocity_m_s = bounced.velocity_m_s, motion.spin_rad_s = bounced.spin_rad_s;
    }
}

void Subdomain::pack_loads(Messages& messages) const {
    for (const Loads::Noted& push : world_.loads.noted())
        for (const int part : joined_holders_.at(push.member)) messages[part].write(push);
}

void Subdomain::unpack_loads(ByteReader& in) {
    while (!in.done()) world_.loads.add_note(in.read<Loads::Noted>());
}

}  // namespace meld::physics
