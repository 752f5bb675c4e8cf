// Merging and splitting composites, and what a snapshot holds of them.
#include "physics/bodies/composites.h"

#include <algorithm>
#include <iterator>
#include <map>

#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

constexpr std::uint32_t kMembersPerJob = 1024;

Vec3 spin_of(const BodyVelocity& velocity, double radius) {
    const float(&u)[3] = velocity.surface;
    return (1 / radius) * Vec3{static_cast<double>(u[0]), static_cast<double>(u[1]), static_cast<double>(u[2])};
}

}  // namespace

void Composites::note(BodyId body) {
    pending_ = true;
    if (const std::uint32_t composite = composite_of(body); composite != kNoComposite) composites_[composite].changed = 1;
}

void Composites::connect(BodyId one, BodyId other) {
    if (!connections_.connect(one, other)) return;
    note(one), note(other);
}

void Composites::release(BodyId one, BodyId other) {
    if (!connections_.release(one, other)) return;
    note(one), note(other);
}

void Composites::release_all(BodyId body) {
    if (connections_.neighbours(body).empty()) return;
    connections_.release_all(body);
    note(body);
}

void Composites::body_moved(BodyId body) {
    const std::uint32_t composite = composite_of(body);
    if (composite == kNoComposite) return;
    pending_ = true;
    composites_[composite].changed = composites_[composite].moved = 1;
    connections_.touch(body);
}

bool Composites::settle(Bodies& bodies, const BodyShapes& shapes) {
    if (!pending_) return false;
    pending_ = false;
    // A connection between two bodies that others hold together changes nothing.
    for (Composite& old : composites_)
        if (old.changed != 0 && connections_.in_same_group(members_[old.first].id)) old.changed = 0;
    const std::vector<std::vector<BodyId>> groups = connections_.take_changed();
    std::map<BodyId, std::size_t> by_first;
    for (std::size_t i = 0; i < groups.size(); ++i) by_first.emplace(groups[i].front(), i);
    // A composite stays if nothing has touched it, or if it has the same members again.
    const auto stays = [&](const Composite& old) {
        if (old.changed == 0) return true;
        const auto group = by_first.find(members_[old.first].id);
        return old.moved == 0 && group != by_first.end() && std::ranges::equal(members(old), groups[group->second], {}, &Member::id);
    };
    std::vector<std::pair<const Composite*, const std::vector<BodyId>*>> all;
    std::vector<BodyId> freed;
    for (const Composite& old : composites_) {
        if (stays(old)) {
            all.emplace_back(&old, nullptr);
            by_first.erase(members_[old.first].id);
        } else {
            for (const Member& member : members(old)) freed.push_back(member.id);
        }
    }
    for (const auto& [first, group] : by_first) all.emplace_back(nullptr, &groups[group]);
    const bool changed = !freed.empty() || !by_first.empty();
    std::ranges::sort(all, {}, [&](const auto& entry) { return entry.first ? members_[entry.first->first].id : entry.second->front(); });

    for (const BodyId body : freed) {
        of_id_[body] = kNoComposite;
        const std::uint32_t slot = bodies.slot(body);
        bodies.properties[slot].flags &= static_cast<std::uint8_t>(~kMember);
        bodies.restore_masses(slot);
    }
    std::vector<Composite> composites;
    std::vector<Member> members;
    composites.reserve(all.size()), members.reserve(members_.size());
    for (const auto& [old, group] : all) {
        const auto first = static_cast<std::uint32_t>(members.size());
        Composite& made = composites.emplace_back(old ? *old : Composite{});
        if (old)
            std::ranges::copy(this->members(*old), std::back_inserter(members));
        else
            make(bodies, shapes, *group, made, members);
        made.first = first;
        made.changed = made.moved = 0;
    }
    composites_ = std::move(composites), members_ = std::move(members);
    if (changed) index(bodies);
    return changed;
}

Symmetric Composites::own_inertia(const Member& member, const Bodies& bodies, const BodyShapes& shapes) {
    const BodyProperties& what = bodies.properties[member.slot];
    const double mass = static_cast<double>(what.mass), radius = bodies.place[member.slot].radius;
    if ((what.flags & kShaped) == 0) {
        const double own = static_cast<double>(what.inertia_factor) * mass * radius * radius;
        return {own, 0, 0, own, 0, own};
    }
    const BodyShapes::Kind& kind = shapes.kind(shapes.of(what.id));
    const Vec3 about = mass * kind.inertia_per_kg_m2;
    const Symmetric own{about.x, 0, 0, about.y, 0, about.z};
    if (kind.turns_alike) return own;
    // Orientations have single precision.
    return turned(own, unit(member.turn));
}

void Composites::make(const Bodies& bodies, const BodyShapes& shapes, const std::vector<BodyId>& group, Composite& made,
                      std::vector<Member>& members) const {
    MELD_EXPECT(group.size() > 1, "{} bodies", group.size());
    made.count = static_cast<std::uint32_t>(group.size());
    const auto mass_of = [&](std::uint32_t slot) { return static_cast<double>(bodies.properties[slot].mass); };
    // Positions count from the first body's, which loses no digits far from the origin.
    const Vec3 origin = centre_of(bodies.place[bodies.slot(group.front())]);
    Vec3 moment, momentum;
    const std::size_t begin = members.size();
    for (const BodyId id : group) {
        const std::uint32_t slot = bodies.slot(id);
        const double mass = mass_of(slot);
        made.mass_kg += mass;
        moment = moment + mass * (centre_of(bodies.place[slot]) - origin);
        momentum = momentum + mass * velocity_of(bodies.velocity[slot]);
        if ((bodies.properties[slot].flags & kFixed) != 0) made.carrier = std::min(made.carrier, id);
        members.push_back({id, slot, {}, {}});
    }
    CompositeMotion& motion = made.motion;
    motion.centre_m = origin + (1 / made.mass_kg) * moment;
    motion.velocity_m_s = (1 / made.mass_kg) * momentum;
    Vec3 angular;
    for (std::size_t i = begin; i < members.size(); ++i) {
        Member& member = members[i];
        const Place& place = bodies.place[member.slot];
        const double mass = mass_of(member.slot);
        member.offset_m = centre_of(place) - motion.centre_m;
        member.turn = widened(bodies.orientation[member.slot]);
        const Symmetric own = own_inertia(member, bodies, shapes);
        made.inertia += inertia_about(mass, own, member.offset_m);
        angular = angular + (mass * cross(member.offset_m, velocity_of(bodies.velocity[member.slot]) - motion.velocity_m_s) +
                             own * spin_of(bodies.velocity[member.slot], place.radius));
    }
    made.inverse_inertia = inverse(made.inertia);
    motion.spin_rad_s = made.inverse_inertia * angular;
    if (!made.carried()) return;
    const std::uint32_t slot = bodies.slot(made.carrier);
    const Vec3 shift = centre_of(bodies.place[slot]) - motion.centre_m;
    for (std::size_t i = begin; i < members.size(); ++i) members[i].offset_m = members[i].offset_m - shift;
    motion.centre_m = centre_of(bodies.place[slot]);
    motion.velocity_m_s = velocity_of(bodies.velocity[slot]);
    motion.spin_rad_s = spin_of(bodies.velocity[slot], bodies.place[slot].radius);
}

void Composites::index(Bodies& bodies) {
    ranges_.clear();
    jobs_.assign(1, 0);
    std::uint32_t in_job = 0;
    for (std::uint32_t c = 0; c < composites_.size(); ++c) {
        const Composite& composite = composites_[c];
        const std::uint32_t behind = composite.first + composite.count;
        for (std::uint32_t first = composite.first; first < behind; first += kMembersPerJob) {
            ranges_.push_back({c, first, std::min(first + kMembersPerJob, behind)});
            if (in_job += ranges_.back().end - first; in_job < kMembersPerJob) continue;
            jobs_.push_back(static_cast<std::uint32_t>(ranges_.size()));
            in_job = 0;
        }
        for (std::uint32_t i = composite.first; i < composite.first + composite.count; ++i) {
            const BodyId body = members_[i].id;
            if (body >= of_id_.size()) of_id_.resize(std::max<std::size_t>(body + std::size_t{1}, 2 * of_id_.size()), kNoComposite);
            of_id_[body] = c;
        }
    }
    if (in_job > 0) jobs_.push_back(static_cast<std::uint32_t>(ranges_.size()));
    locate(bodies);
    for (const Member& member : members_) {
        bodies.properties[member.slot].flags |= kMember;
        bodies.restore_masses(member.slot);
    }
}

void Composites::locate(const Bodies& bodies) {
    for (Member& member : members_) member.slot = bodies.slot(member.id);
}

void Composites::keep() {
    kept_.clear();
    for (const Composite& composite : composites_) kept_.push_back(composite.motion);
}

void Composites::restore() {
    if (kept_.size() != composites_.size()) return;
    for (std::size_t c = 0; c < kept_.size(); ++c) composites_[c].motion = kept_[c], composites_[c].asleep = 0;
}

void Composites::write(ByteWriter& out) const {
    const auto pairs = connections_.all();
    out.write_count(pairs.size());
    for (const auto& [one, other] : pairs) out.write(one), out.write(other);
    out.write_count(composites_.size());
    for (const Composite& composite : composites_) out.write(composite);
    out.write_count(members_.size());
    for (Member member : members_) {
        member.slot = 0;
        out.write(member);
    }
    out.write(pending_);
}

bool Composites::read(ByteReader& in) {
    for (auto left = in.read_count(2 * sizeof(BodyId)); left > 0; --left) {
        const auto one = in.read<BodyId>(), other = in.read<BodyId>();
        if (one >= other || other >= kMaxBodies) return false;
        connections_.connect(one, other);
    }
    composites_.resize(in.read_count(sizeof(Composite)));
    for (Composite& composite : composites_) composite = in.read<Composite>();
    members_.resize(in.read_count(sizeof(Member)));
    for (Member& member : members_) member = in.read<Member>();
    pending_ = in.read<bool>();
    std::uint64_t next = 0;
    for (const Composite& composite : composites_) {
        if (composite.first != next || composite.count < 2) return false;
        next += composite.count;
    }
    return !in.failed() && next == members_.size();
}

bool Composites::loaded(Bodies& bodies) {
    const auto missing = [&](BodyId body) { return !bodies.has(body); };
    if (std::ranges::any_of(members_, missing, &Member::id)) return false;
    for (const auto& [one, other] : connections_.all())
        if (missing(one) || missing(other)) return false;
    index(bodies);
    return true;
}

std::size_t Composites::bytes() const {
    return connections_.bytes() + composites_.capacity() * sizeof(Composite) + members_.capacity() * sizeof(Member) +
           ranges_.capacity() * sizeof(Range) + of_id_.capacity() * sizeof(std::uint32_t) + kept_.capacity() * sizeof(CompositeMotion);
}

}  // namespace meld::physics
