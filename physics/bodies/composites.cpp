// Merging and splitting composites, and what a snapshot holds of them.
#include "physics/bodies/composites.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <ranges>
#include <utility>

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

const Composites::Member& Composites::member_of(BodyId body) const {
    const std::uint32_t composite = composite_of(body);
    MELD_EXPECT(composite != kNoComposite, "body {} is in no composite", body);
    return *std::ranges::lower_bound(members(composites_[composite]), body, {}, &Member::id);
}

bool Composites::settle(Bodies& bodies, const BodyShapes& shapes) {
    if (!pending_) return false;
    if (!find_changes([](BodyId) { return true; })) return false;
    make_changes(bodies, shapes);
    return true;
}

bool Composites::stays(const Composite& composite) const {
    // A connection between two bodies that others hold together changes nothing.
    if (composite.changed == 0 || connections_.in_same_group(members_[composite.first].id)) return true;
    return composite.moved == 0 && connections_.are_a_group(members(composite) | std::views::transform(&Member::id));
}

bool Composites::find_changes(const std::function<bool(BodyId)>& here) {
    new_groups_.clear(), ends_.clear();
    if (!pending_) return false;
    pending_ = false;
    for (const Composite& old : composites_) ends_.push_back(stays(old) ? 0 : 1);
    std::vector<std::vector<BodyId>> groups = connections_.take_changed();
    std::map<BodyId, std::size_t> by_first;
    for (std::size_t i = 0; i < groups.size(); ++i)
        if (std::ranges::any_of(groups[i], here)) by_first.emplace(groups[i].front(), i);
    bool any_ends = std::exchange(left_out_, false);
    for (std::size_t c = 0; c < composites_.size(); ++c) {
        any_ends = any_ends || ends_[c] != 0;
        if (ends_[c] == 0) by_first.erase(members_[composites_[c].first].id);
        composites_[c].changed = composites_[c].moved = 0;
    }
    for (const auto& [first, group] : by_first) new_groups_.push_back(std::move(groups[group]));
    return any_ends || !new_groups_.empty();
}

void Composites::make_changes(Bodies& bodies, const BodyShapes& shapes) {
    MELD_EXPECT(ends_.size() == composites_.size(), "{} of {} composites", ends_.size(), composites_.size());
    std::vector<std::pair<const Composite*, const std::vector<BodyId>*>> all;
    for (std::size_t c = 0; c < composites_.size(); ++c) {
        if (ends_[c] == 0) {
            all.emplace_back(&composites_[c], nullptr);
            continue;
        }
        for (const Member& member : members(composites_[c])) {
            of_id_[member.id] = kNoComposite;
            const std::uint32_t slot = bodies.slot(member.id);
            bodies.properties[slot].flags &= static_cast<std::uint8_t>(~kMember);
            bodies.restore_masses(slot);
        }
    }
    for (const std::vector<BodyId>& group : new_groups_) all.emplace_back(nullptr, &group);
    std::ranges::sort(all, {}, [&](const auto& entry) { return entry.first ? members_[entry.first->first].id : entry.second->front(); });
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
    }
    composites_ = std::move(composites), members_ = std::move(members);
    new_groups_.clear(), ends_.clear();
    index(bodies);
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
    return turned(own, kind.principal(unit(member.turn)));
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

void Composites::write(const Composite& composite, ByteWriter& out) const {
    Composite written = composite;
    written.first = 0;
    out.write(written);
    for (Member member : members(composite)) {
        member.slot = 0;
        out.write(member);
    }
}

bool Composites::read_one(ByteReader& in) {
    Composite& composite = composites_.emplace_back(in.read<Composite>());
    if (in.failed() || composite.count < 2 || composite.count > in.left() / sizeof(Member)) return false;
    composite.first = static_cast<std::uint32_t>(members_.size());
    for (std::uint32_t i = 0; i < composite.count; ++i) members_.push_back(in.read<Member>());
    return true;
}

void Composites::sort_all() {
    const auto first_of = [&](const Composite& composite) { return members_[composite.first].id; };
    if (std::ranges::is_sorted(composites_, {}, first_of)) return;
    std::ranges::sort(composites_, {}, first_of);
    std::vector<Member> all;
    all.reserve(members_.size());
    for (Composite& composite : composites_) {
        const auto first = static_cast<std::uint32_t>(all.size());
        std::ranges::copy(members(composite), std::back_inserter(all));
        composite.first = first;
    }
    members_ = std::move(all);
}

void Composites::keep(const std::vector<bool>& chosen) {
    MELD_EXPECT(chosen.size() == composites_.size(), "{} of {} composites", chosen.size(), composites_.size());
    std::vector<Composite> kept;
    std::vector<Member> all;
    for (std::size_t c = 0; c < chosen.size(); ++c) {
        if (!chosen[c]) {
            for (const Member& member : members(composites_[c]))
                if (member.id < of_id_.size()) of_id_[member.id] = kNoComposite;
            continue;
        }
        const auto first = static_cast<std::uint32_t>(all.size());
        std::ranges::copy(members(composites_[c]), std::back_inserter(all));
        kept.push_back(composites_[c]);
        kept.back().first = first;
    }
    composites_ = std::move(kept), members_ = std::move(all);
}

void Composites::arrange(Bodies& bodies) {
    sort_all();
    index(bodies);
}

void Composites::write(ByteWriter& out, const std::function<bool(BodyId)>& ours) const {
    auto pairs = connections_.all();
    std::erase_if(pairs, [&](const auto& pair) { return !ours(pair.first); });
    out.write_count(pairs.size());
    for (const auto& [one, other] : pairs) out.write(one), out.write(other);
    std::vector<Composite> composites;
    std::vector<Member> members;
    bool leaves_out = left_out_;
    for (const Composite& composite : composites_) {
        if (!stays(composite)) {
            leaves_out = true;
            continue;
        }
        if (!ours(members_[composite.first].id)) continue;
        composites.push_back(composite);
        composites.back().first = static_cast<std::uint32_t>(members.size());
        std::ranges::copy(this->members(composite), std::back_inserter(members));
    }
    out.write_count(composites.size());
    for (const Composite& composite : composites) out.write(composite);
    out.write_count(members.size());
    for (Member& member : members) {
        member.slot = 0;
        out.write(member);
    }
    out.write(static_cast<std::uint8_t>(!pending_ ? 0 : leaves_out ? 2 : 1));
}

bool Composites::read(ByteReader& in) {
    for (auto left = in.read_count(2 * sizeof(BodyId)); left > 0; --left) {
        const auto one = in.read<BodyId>(), other = in.read<BodyId>();
        if (one >= other || other >= kMaxBodies) return false;
        connections_.connect(one, other);
    }
    const std::size_t before = composites_.size(), first = members_.size();
    composites_.resize(before + in.read_count(sizeof(Composite)));
    for (std::size_t c = before; c < composites_.size(); ++c) composites_[c] = in.read<Composite>();
    members_.resize(first + in.read_count(sizeof(Member)));
    for (std::size_t m = first; m < members_.size(); ++m) members_[m] = in.read<Member>();
    const auto pending = in.read<std::uint8_t>();
    pending_ = pending != 0 || pending_;
    left_out_ = pending == 2 || left_out_;
    std::uint64_t next = 0;
    for (std::size_t c = before; c < composites_.size(); ++c) {
        Composite& composite = composites_[c];
        if (composite.first != next || composite.count < 2) return false;
        next += composite.count;
        composite.first += static_cast<std::uint32_t>(first);
    }
    if (in.failed() || first + next != members_.size()) return false;
    sort_all();
    return true;
}

bool Composites::loaded(Bodies& bodies, bool divided) {
    const auto missing = [&](BodyId body) { return !bodies.has(body); };
    if (std::ranges::any_of(members_, missing, &Member::id)) return false;
    for (const auto& [one, other] : connections_.all())
        if (!divided && (missing(one) || missing(other))) return false;
    index(bodies);
    return true;
}

std::size_t Composites::bytes() const {
    return connections_.bytes() + composites_.capacity() * sizeof(Composite) + members_.capacity() * sizeof(Member) +
           ranges_.capacity() * sizeof(Range) + of_id_.capacity() * sizeof(std::uint32_t) + kept_.capacity() * sizeof(CompositeMotion);
}

}  // namespace meld::physics
