// A composite as statics sees it, its members with what acts on them and the connections between them, and how it breaks.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "physics/bodies/symmetric.h"
#include "physics/statics/connection_load.h"
#include "physics/statics/seat.h"
#include "physics/statics/stiff_lattice.h"

namespace meld::physics {

struct PieceMember {
    BodyId id = 0;
    Vec3 place_m = {};
    double radius_m = 0.5, mass_kg = 1;
    // About its own centre.
    Symmetric inertia_kg_m2 = {};
    bool fixed = false;
    Pull acts = {};
};
struct PieceConnection {
    std::uint32_t one = 0, other = 0;
    BreakingLimits limits;
    // Of two spheres: on the line between their centres, where their surfaces meet.
    std::optional<Seat> seat = {};
    ConnectionLoad load = {};
    bool broken = false;
};

class OverloadedPiece {
  public:
    OverloadedPiece(std::vector<PieceMember> members, std::vector<PieceConnection> connections)
        : members_(std::move(members)), connections_(std::move(connections)) {}

    // Finds the loads; then breaks the most overloaded connection and finds those of the parts, as often as needed, at most so many times.
    // `kept`: the lattice of the whole piece, if it was made before. False if some were not found.
    bool solve(std::optional<StiffLattice>& kept, int most_breaks);
    std::span<const PieceMember> members() const { return members_; }
    std::span<const PieceConnection> connections() const { return connections_; }

  private:
    // Members and connections, by their numbers.
    struct Part {
        std::vector<std::uint32_t> members, connections;
    };
    bool carry(const Part& part, std::optional<StiffLattice>& lattice);
    // What acts on the members of a part that nothing holds, with the inertia that balances it.
    std::vector<Pull> balanced(const Part& part) const;
    std::optional<std::uint32_t> most_overloaded(const Part& part) const;
    std::vector<Part> parts_without_broken(const Part& part) const;

    std::vector<PieceMember> members_;
    std::vector<PieceConnection> connections_;
};

}  // namespace meld::physics
