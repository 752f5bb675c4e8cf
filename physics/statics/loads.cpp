#include "physics/statics/loads.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "physics/statics/overloaded_piece.h"
#include "physics/statics/seat.h"
#include "runtime/base/assert.h"

namespace meld::physics {

// Of a map, with its three pointers, its colour and the heap.
constexpr std::size_t kLimitNode_bytes = sizeof(std::pair<const BodyId, BreakingLimits>) + 48;

struct Loads::Kept {
    // Of a connection with a shape, and what it was found from.
    struct Sat {
        ConnectionPair pair;
        Seated one, other;
        Seat seat;
    };
    BodyId first = kMaxBodies;
    std::optional<StiffLattice> lattice = {};
    std::vector<Sat> seats = {};  // Sorted.
};

namespace {

// The torque that turns a body's own angular momentum along with the body: -w x I w, from the products of w's components.
Vec3 turning_along(const Symmetric& spin_spin, const Symmetric& inertia) {
    // Columns of Q I.
    const Vec3 x = spin_spin * Vec3{inertia.xx, inertia.xy, inertia.xz}, y = spin_spin * Vec3{inertia.xy, inertia.yy, inertia.yz},
               z = spin_spin * Vec3{inertia.xz, inertia.yz, inertia.zz};
    return {y.z - z.y, z.x - x.z, x.y - y.x};
}

}  // namespace

Loads::Loads() = default;
Loads::~Loads() = default;

struct Loads::Solved {
    std::vector<CarriedLoad> carried;
    std::vector<ConnectionPair> broken;
    bool found = true;
};

double ConnectionLoad::torque_nm() const { return std::sqrt(bending_nm * bending_nm + twist_nm * twist_nm); }

double ConnectionLoad::tearing_n() const {
    const double pull = std::max(tension_n, 0.0);
    return std::sqrt(pull * pull + shear_n * shear_n);
}

void Loads::set_limits(BodyId body, const BreakingLimits& limits) {
    if (limits == BreakingLimits{})
        limits_.erase(body);
    else
        limits_[body] = limits;
}

BreakingLimits Loads::limits_of(BodyId body) const {
    const auto at = limits_.find(body);
    return at != limits_.end() ? at->second : BreakingLimits{};
}

void Loads::begin(const Composites& composites, bool recomposed) {
    if (!recomposed && sums_.size() == composites.all().size() && acted_.size() == composites.members().size()) return;
    sums_.assign(composites.all().size(), {});
    acted_.assign(composites.members().size(), {});
}

void Loads::push(const Composites& composites, std::uint32_t index, std::uint32_t member, Vec3 impulse_ns, Vec3 turning_nms, Order order) {
    MELD_EXPECT(member < acted_.size(), "member {} of {}", member, acted_.size());
    const Quat back = conjugate(composites.all()[index].motion.turn);
    const Pull pull{rotate(back, impulse_ns), rotate(back, turning_nms)};
    if (notes_) {
        noted_.push_back({order.block, order.turn, composites.members()[member].id, pull});
        return;
    }
    Pull& sum = acted_[member];
    sum.force = sum.force + pull.force;
    sum.torque = sum.torque + pull.torque;
}

void Loads::add(const Composites& composites, BodyId body, const Pull& pull) {
    MELD_CHECK(composites.composite_of(body) != kNoComposite, "body {} is pushed here, and has no composite", body);
    Pull& sum = acted_[static_cast<std::size_t>(&composites.member_of(body) - composites.members().data())];
    sum.force = sum.force + pull.force;
    sum.torque = sum.torque + pull.torque;
}

void Loads::add_push(const Composites& composites, BodyId body, Vec3 impulse_ns, Vec3 turning_nms) {
    const Quat back = conjugate(composites.all()[composites.composite_of(body)].motion.turn);
    add(composites, body, {rotate(back, impulse_ns), rotate(back, turning_nms)});
}

void Loads::add_noted(const Composites& composites) {
    std::ranges::stable_sort(noted_, {}, [](const Noted& push) { return std::pair{push.turn, push.block}; });
    for (const Noted& push : noted_) add(composites, push.member, push.pull);
    noted_.clear();
}

void Loads::end_step(const Composites& composites, const Wrench* first, const Wrench* second, Vec3 gravity_m_s2, double step_s) {
    MELD_EXPECT(sums_.size() == composites.all().size(), "{} of {} composites", sums_.size(), composites.all().size());
    for (std::size_t c = 0; c < sums_.size(); ++c) {
        const Composite& composite = composites.all()[c];
        if (composite.asleep != 0) continue;
        Sums& sums = sums_[c];
        const Quat back = conjugate(composite.motion.turn);
        const Vec3 w = rotate(back, composite.motion.spin_rad_s);
        sums.time_s += step_s;
        sums.gravity = sums.gravity + step_s * rotate(back, gravity_m_s2);
        Symmetric& square = sums.spin_spin;
        square.xx += step_s * w.x * w.x, square.xy += step_s * w.x * w.y, square.xz += step_s * w.x * w.z;
        square.yy += step_s * w.y * w.y, square.yz += step_s * w.y * w.z, square.zz += step_s * w.z * w.z;
        for (const Wrench* wrenches : {first, second}) {
            if (!wrenches) continue;
            for (std::uint32_t m = composite.first; m < composite.first + composite.count; ++m) {
                const Wrench& wrench = wrenches[composites.members()[m].slot];
                acted_[m].force = acted_[m].force + rotate(back, step_s * widened(wrench.force));
                acted_[m].torque = acted_[m].torque + rotate(back, step_s * widened(wrench.torque));
            }
        }
    }
}

void Loads::forget() {
    sums_.clear(), acted_.clear(), noted_.clear();
    if (!wanted()) carried_.clear();
}

Loads::Solved Loads::solve_one(const Composites& composites, const Composite& composite, const Sums& sums, const Bodies& bodies,
                               const BodyShapes& shapes, Kept& kept) const {
    const double share = 1 / sums.time_s;
    const Vec3 gravity = share * sums.gravity;
    const Symmetric& q = sums.spin_spin;
    const double trace = q.xx + q.yy + q.zz;
    const auto all = composites.members(composite);
    std::vector<PieceMember> members;
    members.reserve(all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
        const Composites::Member& member = all[i];
        const BodyProperties& properties = bodies.properties[member.slot];
        const double mass = static_cast<double>(properties.mass), radius = bodies.place[member.slot].radius;
        // What turns away from the axis: -w x (w x r) = |w|^2 r - w (w.r).
        const Vec3 outwards = share * (trace * member.offset_m - q * member.offset_m);
        const Pull& acted = acted_[composite.first + i];
        const Symmetric own = Composites::own_inertia(member, bodies, shapes);
        Vec3 torque = share * acted.torque;
        if ((properties.flags & kShaped) != 0) torque = torque + share * turning_along(q, own);
        members.push_back({.id = member.id,
                           .place_m = member.offset_m,
                           .radius_m = radius,
                           .mass_kg = mass,
                           .inertia_kg_m2 = own,
                           .fixed = (properties.flags & kFixed) != 0,
                           .acts = {share * acted.force + mass * (gravity + outwards), torque}});
    }
    const auto seated = [&](const Composites::Member& member) {
        const BodyShapes::Index index = shapes.of(member.id);
        return Seated{index == 0 ? BodyShape{{}, bodies.place[member.slot].radius} : shapes.kind(index).shape, member.offset_m,
                      member.turn};
    };
    std::vector<Kept::Sat> seats;
    auto former = kept.seats.begin();
    const auto seat_of = [&](const Composites::Member& one, const Composites::Member& other) -> std::optional<Seat> {
        if (((bodies.properties[one.slot].flags | bodies.properties[other.slot].flags) & kShaped) == 0) return std::nullopt;
        Kept::Sat& sat = seats.emplace_back(Kept::Sat{{one.id, other.id}, seated(one), seated(other), {}});
        while (former != kept.seats.end() && former->pair < sat.pair) ++former;
        const bool same = former != kept.seats.end() && former->pair == sat.pair && former->one == sat.one && former->other == sat.other;
        sat.seat = same ? former->seat : seat_between(sat.one, sat.other);
        return sat.seat;
    };
    std::vector<PieceConnection> connections;
    std::vector<BodyId> others;
    for (std::uint32_t one = 0; one < all.size(); ++one) {
        const auto neighbours = composites.connections().neighbours(all[one].id);
        others.assign(neighbours.begin(), neighbours.end());
        std::ranges::sort(others);
        const BreakingLimits mine = limits_of(all[one].id);
        for (const BodyId id : others) {
            if (id < all[one].id) continue;
            // Not a member if it was connected after the step.
            const auto other = std::ranges::lower_bound(all, id, {}, &Composites::Member::id);
            if (other == all.end() || other->id != id) continue;
            const BreakingLimits theirs = limits_of(id);
            connections.push_back({.one = one,
                                   .other = static_cast<std::uint32_t>(other - all.begin()),
                                   .limits = {std::min(mine.force_n, theirs.force_n), std::min(mine.torque_nm, theirs.torque_nm)},
                                   .seat = seat_of(all[one], *other)});
        }
    }
    kept.seats = std::move(seats);
    OverloadedPiece piece(std::move(members), std::move(connections));
    Solved solved;
    solved.found = piece.solve(kept.lattice, kMostBreaks);
    for (const PieceConnection& connection : piece.connections()) {
        const ConnectionPair pair{piece.members()[connection.one].id, piece.members()[connection.other].id};
        if (connection.broken)
            solved.broken.push_back(pair);
        else
            solved.carried.push_back({pair, connection.load});
    }
    return solved;
}

Result<std::vector<ConnectionPair>> Loads::solve(const Composites& composites, const Bodies& bodies, const BodyShapes& shapes,
                                                 Workers& workers) {
    const std::span<const Composite> all = composites.all();
    begin(composites, false);
    // Lattices of composites that are the same again, by their first members, which are in order.
    std::vector<Kept> kept(all.size());
    auto former = kept_.begin();
    for (std::size_t c = 0; c < all.size(); ++c) {
        kept[c].first = composites.members()[all[c].first].id;
        while (former != kept_.end() && former->first < kept[c].first) ++former;
        if (former != kept_.end() && former->first == kept[c].first)
            kept[c].lattice = std::move(former->lattice), kept[c].seats = std::move(former->seats);
    }
    kept_ = std::move(kept);
    std::vector<Solved> solved(all.size());
    workers.run(all.size(), [&](int, std::size_t c) {
        if (sums_[c].time_s > 0) solved[c] = solve_one(composites, all[c], sums_[c], bodies, shapes, kept_[c]);
    });
    std::vector<CarriedLoad> carried;
    // Of those that have slept since the last call.
    for (const CarriedLoad& load : carried_) {
        const std::uint32_t composite = composites.composite_of(load.pair.first);
        if (composite != kNoComposite && sums_[composite].time_s == 0 &&
            composites.connections().connected(load.pair.first, load.pair.second))
            carried.push_back(load);
    }
    std::vector<ConnectionPair> broken;
    bool found = true;
    for (std::size_t c = 0; c < all.size(); ++c) {
        found = found && solved[c].found;
        carried.insert(carried.end(), solved[c].carried.begin(), solved[c].carried.end());
        broken.insert(broken.end(), solved[c].broken.begin(), solved[c].broken.end());
    }
    std::ranges::sort(carried, {}, &CarriedLoad::pair);
    std::ranges::sort(broken);
    carried_ = std::move(carried);
    std::ranges::fill(sums_, Sums{});
    std::ranges::fill(acted_, Pull{});
    if (!found)
        return fail("the loads of some connections were not found (the forces on a composite are not finite, or its shape is too slender)",
                    "Look at the forces on its bodies, or connect fewer of them");
    return broken;
}

std::optional<ConnectionLoad> Loads::of(BodyId one, BodyId other) const {
    const ConnectionPair pair = std::minmax(one, other);
    const auto at = std::ranges::lower_bound(carried_, pair, {}, &CarriedLoad::pair);
    return at != carried_.end() && at->pair == pair ? std::optional(at->load) : std::nullopt;
}

Loads::OfComposites Loads::take_out(const Composites& composites) {
    OfComposites all;
    const bool summed = sums_.size() == composites.all().size() && acted_.size() == composites.members().size();
    for (std::size_t c = 0; c < composites.all().size(); ++c) {
        const Composite& composite = composites.all()[c];
        OfComposite& of = all[composites.members(composite).front().id];
        of.acted.resize(composite.count);
        if (!summed) continue;
        of.sums = sums_[c];
        std::copy_n(acted_.begin() + composite.first, composite.count, of.acted.begin());
    }
    // Loads are found by their bodies, wherever these are.
    sums_.clear(), acted_.clear();
    return all;
}

void Loads::put_in(OfComposites all, const Composites& composites) {
    sums_.clear();
    acted_.assign(composites.members().size(), {});
    for (const Composite& composite : composites.all()) {
        OfComposite& of = all[composites.members(composite).front().id];
        of.acted.resize(composite.count);
        sums_.push_back(of.sums);
        std::ranges::copy(of.acted, acted_.begin() + composite.first);
        carried_.insert(carried_.end(), of.carried.begin(), of.carried.end());
    }
    std::ranges::sort(carried_, {}, &CarriedLoad::pair);
    const auto twice = std::ranges::unique(carried_, {}, &CarriedLoad::pair);
    carried_.erase(twice.begin(), twice.end());
}

namespace {

void write_loads(std::span<const CarriedLoad> loads, ByteWriter& out) {
    out.write_count(loads.size());
    for (const auto& [pair, load] : loads)
        for (const BodyId body : {pair.first, pair.second}) out.write(body);
    for (const auto& [pair, load] : loads) out.write(load);
}

std::vector<CarriedLoad> read_loads(ByteReader& in) {
    std::vector<CarriedLoad> loads(in.read_count(2 * sizeof(BodyId) + sizeof(ConnectionLoad)));
    for (CarriedLoad& load : loads) load.pair.first = in.read<BodyId>(), load.pair.second = in.read<BodyId>();
    for (CarriedLoad& load : loads) load.load = in.read<ConnectionLoad>();
    return loads;
}

}  // namespace

void Loads::write(const Composites& composites, const Composite& composite, ByteWriter& out) const {
    const auto members = composites.members(composite);
    const auto at = static_cast<std::size_t>(&composite - composites.all().data());
    const bool summed = sums_.size() == composites.all().size() && acted_.size() == composites.members().size();
    out.write(summed ? sums_[at] : Sums{});
    out.write_count(members.size());
    for (std::size_t m = 0; m < members.size(); ++m) out.write(summed ? acted_[composite.first + m] : Pull{});
    std::vector<CarriedLoad> carried;
    for (const Composites::Member& member : members) {
        const auto its = std::ranges::equal_range(carried_, member.id, {}, [](const CarriedLoad& load) { return load.pair.first; });
        carried.insert(carried.end(), its.begin(), its.end());
    }
    write_loads(carried, out);
}

Loads::OfComposite Loads::read_one(ByteReader& in) {
    OfComposite of{.sums = in.read<Sums>(), .acted = std::vector<Pull>(in.read_count(sizeof(Pull))), .carried = {}};
    for (Pull& pull : of.acted) pull = in.read<Pull>();
    of.carried = read_loads(in);
    return of;
}

// After a tick nothing is added up; an undivided world may be saved earlier.
void Loads::write(ByteWriter& out, bool divided, const std::function<bool(BodyId)>& ours) const {
    out.write_count(limits_.size());
    for (const auto& [body, limits] : limits_) out.write(body), out.write(limits.force_n), out.write(limits.torque_nm);
    std::vector<CarriedLoad> carried = carried_;
    std::erase_if(carried, [&](const CarriedLoad& load) { return !ours(load.pair.first); });
    write_loads(carried, out);
    out.write_count(divided ? 0 : sums_.size());
    for (std::size_t c = 0; c < (divided ? 0 : sums_.size()); ++c) out.write(sums_[c]);
    out.write_count(divided ? 0 : acted_.size());
    for (std::size_t m = 0; m < (divided ? 0 : acted_.size()); ++m) out.write(acted_[m]);
}

void Loads::read(ByteReader& in) {
    for (auto left = in.read_count(sizeof(BodyId) + 2 * sizeof(double)); left > 0; --left) {
        const auto body = in.read<BodyId>();
        const auto force = in.read<double>(), torque = in.read<double>();
        set_limits(body, {force, torque});
    }
    const std::vector<CarriedLoad> more = read_loads(in);
    carried_.insert(carried_.end(), more.begin(), more.end());
    std::ranges::sort(carried_, {}, &CarriedLoad::pair);
    sums_.resize(in.read_count(sizeof(Sums)));
    for (Sums& sums : sums_) sums = in.read<Sums>();
    acted_.resize(in.read_count(sizeof(Pull)));
    for (Pull& pull : acted_) pull = in.read<Pull>();
}

std::size_t Loads::bytes() const {
    std::size_t sum = limits_.size() * kLimitNode_bytes + sums_.capacity() * sizeof(Sums) + acted_.capacity() * sizeof(Pull) +
                      carried_.capacity() * sizeof(CarriedLoad) + noted_.capacity() * sizeof(Noted) + kept_.capacity() * sizeof(Kept);
    for (const Kept& kept : kept_) sum += kept.seats.capacity() * sizeof(Kept::Sat) + (kept.lattice ? kept.lattice->bytes() : 0);
    return sum;
}

}  // namespace meld::physics
