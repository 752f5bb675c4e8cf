#include "physics/statics/overloaded_piece.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "physics/bodies/symmetric.h"

namespace meld::physics {

namespace {

// Loads that differ by less are equal, so that rounding does not choose which of two connections breaks, but their numbers.
constexpr double kSame = 1e-9;

double overload(const PieceConnection& connection) {
    return std::max(connection.load.tearing_n() / connection.limits.force_n, connection.load.torque_nm() / connection.limits.torque_nm);
}

ConnectionLoad load_of(const Pull& pull, Vec3 along) {
    const double tension = dot(pull.force, along), twist = dot(pull.torque, along);
    return {.tension_n = tension,
            .shear_n = length(pull.force - tension * along),
            .bending_nm = length(pull.torque - twist * along),
            .twist_nm = std::abs(twist)};
}

}  // namespace

std::vector<Pull> OverloadedPiece::balanced(const Part& part) const {
    double mass = 0;
    Vec3 moment, force, torque;
    for (const std::uint32_t m : part.members) {
        mass += members_[m].mass_kg;
        moment = moment + members_[m].mass_kg * members_[m].place_m;
        force = force + members_[m].acts.force;
    }
    const Vec3 centre = (1 / mass) * moment, acceleration = (1 / mass) * force;
    Symmetric inertia;
    for (const std::uint32_t i : part.members) {
        const PieceMember& m = members_[i];
        const Vec3 arm = m.place_m - centre;
        torque = torque + (m.acts.torque + cross(arm, m.acts.force));
        inertia += inertia_about(m.mass_kg, m.inertia_kg_m2, arm);
    }
    const Vec3 turning = inverse(inertia) * torque;
    std::vector<Pull> acts;
    for (const std::uint32_t i : part.members) {
        const PieceMember& m = members_[i];
        acts.push_back(
            {m.acts.force - m.mass_kg * (acceleration + cross(turning, m.place_m - centre)), m.acts.torque - m.inertia_kg_m2 * turning});
    }
    return acts;
}

bool OverloadedPiece::carry(const Part& part, std::optional<StiffLattice>& lattice) {
    std::vector<Pull> acts;
    const bool held = std::ranges::any_of(part.members, [&](std::uint32_t m) { return members_[m].fixed; });
    if (!held) acts = balanced(part);
    std::vector<std::uint32_t> number(members_.size(), kGround);
    std::vector<Vec3> places;
    for (const std::uint32_t m : part.members) {
        if (members_[m].fixed) continue;
        number[m] = static_cast<std::uint32_t>(places.size());
        places.push_back(members_[m].place_m);
        if (held) acts.push_back(members_[m].acts);
    }
    std::vector<Beam> beams;
    std::vector<std::uint32_t> of_beam;
    for (const std::uint32_t c : part.connections) {
        PieceConnection& connection = connections_[c];
        connection.load = {};
        std::uint32_t one = connection.one, other = connection.other;
        const bool swapped = number[one] == kGround;
        if (swapped) std::swap(one, other);
        // Between two fixed members.
        if (number[one] == kGround) continue;
        if (const std::optional<Seat>& seat = connection.seat) {
            beams.push_back({.one = number[one],
                             .other = number[other],
                             .at = seat->at,
                             .along = swapped ? -seat->along : seat->along,
                             .radius_m = seat->radius_m});
            of_beam.push_back(c);
            continue;
        }
        const PieceMember &a = members_[one], &b = members_[other];
        const Vec3 way = b.place_m - a.place_m;
        const double apart = length(way);
        const Vec3 along = apart > 0 ? (1 / apart) * way : Vec3{1, 0, 0};
        beams.push_back({.one = number[one],
                         .other = number[other],
                         .at = a.place_m + (a.radius_m / (a.radius_m + b.radius_m)) * way,
                         .along = along,
                         .radius_m = std::min(a.radius_m, b.radius_m)});
        of_beam.push_back(c);
    }
    if (!lattice || lattice->places() != places || lattice->beams() != beams) lattice.emplace(std::move(places), std::move(beams));
    std::vector<Pull> pulls(of_beam.size());
    const bool found = lattice->solve(acts, pulls);
    for (std::size_t i = 0; i < pulls.size(); ++i) connections_[of_beam[i]].load = load_of(pulls[i], lattice->beams()[i].along);
    return found;
}

std::optional<std::uint32_t> OverloadedPiece::most_overloaded(const Part& part) const {
    double worst = 1 + kSame;
    std::optional<std::uint32_t> found;
    for (const std::uint32_t c : part.connections) {
        const double here = overload(connections_[c]);
        if (!(here > worst * (1 + kSame))) continue;
        worst = here;
        found = c;
    }
    return found;
}

std::vector<OverloadedPiece::Part> OverloadedPiece::parts_without_broken(const Part& part) const {
    std::vector<std::uint32_t> first(members_.size());
    std::iota(first.begin(), first.end(), 0u);
    const auto find = [&](std::uint32_t m) {
        while (first[m] != m) m = first[m] = first[first[m]];
        return m;
    };
    for (const std::uint32_t c : part.connections) {
        if (connections_[c].broken) continue;
        const std::uint32_t one = find(connections_[c].one), other = find(connections_[c].other);
        first[std::max(one, other)] = std::min(one, other);
    }
    std::vector<Part> parts;
    std::vector<std::size_t> part_of(members_.size(), members_.size());
    for (const std::uint32_t m : part.members) {
        std::size_t& index = part_of[find(m)];
        if (index == members_.size()) index = parts.size(), parts.emplace_back();
        parts[index].members.push_back(m);
    }
    for (const std::uint32_t c : part.connections)
        if (!connections_[c].broken) parts[part_of[find(connections_[c].one)]].connections.push_back(c);
    std::erase_if(parts, [](const Part& each) { return each.connections.empty(); });
    return parts;
}

bool OverloadedPiece::solve(std::optional<StiffLattice>& kept, int most_breaks) {
    Part whole;
    whole.members.resize(members_.size()), whole.connections.resize(connections_.size());
    std::iota(whole.members.begin(), whole.members.end(), 0u);
    std::iota(whole.connections.begin(), whole.connections.end(), 0u);
    std::vector<Part> open = parts_without_broken(whole);
    bool found = true;
    for (std::size_t i = 0; i < open.size(); ++i) {
        const Part part = std::move(open[i]);
        std::optional<StiffLattice> own;
        found = carry(part, i == 0 ? kept : own) && found;
        const std::optional<std::uint32_t> worst = most_overloaded(part);
        if (!worst || most_breaks-- <= 0) continue;
        connections_[*worst].broken = true;
        for (Part& each : parts_without_broken(part)) open.push_back(std::move(each));
    }
    return found;
}

}  // namespace meld::physics
