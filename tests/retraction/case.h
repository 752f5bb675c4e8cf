// A random case: a world, what is given to its catoms, and bursts of changes. Made from a seed, printed so that a failure
// can be read, and applied to a mirror that knows what the runtime should have been told.
#pragma once

#include <cstdint>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "runtime/world/lattice.h"

namespace meld::retraction {

using world::Cell;
using Row = std::vector<std::int64_t>;
// What a case gives as a float: its sums have no rounding.
inline double quarters(std::int64_t n) { return static_cast<double>(n) / 4; }
// By predicate: rows that begin with the catom's id.
using Facts = std::map<std::string, std::set<Row>>;

// A predicate whose facts a case gives and takes, and the range of each argument after the catom.
struct Given {
    std::string predicate;
    std::vector<std::pair<std::int64_t, std::int64_t>> arguments = {};
    int per_mille = 100;  // Of the catoms have one at first.
    bool linear = false;  // Turns into a persistent fact `becomes`, which nothing takes away; empty: no matter into what.
    std::string becomes = {};
};

struct Change {
    enum class Kind { Give, Take, Remove, Add, Move } kind = Kind::Give;
    int tick = 0;  // After the start of its burst.
    Cell cell = {};
    Cell to = {};           // Move
    std::size_t given = 0;  // Give, Take: which predicate,
    Row arguments = {};     // and its arguments after the catom.
};

struct Case {
    std::uint64_t seed = 0;
    world::LatticeKind lattice = world::LatticeKind::Square;
    std::vector<Cell> cells;  // As World::cells.
    std::vector<std::vector<Change>> bursts;
};

// What stands where and holds what, by the book.
struct Mirror {
    Mirror(const Case& c, const std::vector<Given>& given);
    // Does what the change says and returns true; false, and nothing, where it makes no sense (any more).
    bool apply(const Change& change);

    const std::vector<Given>& given;
    std::map<Cell, std::uint64_t> at;
    std::uint64_t next_id = 0;
    Facts facts;  // Given ones.
};

using Random = std::mt19937_64;
inline std::int64_t below(Random& random, std::int64_t n) { return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(n)); }

Case make_case(std::uint64_t seed, const std::vector<Given>& given);
// A labyrinth of more than a thousand catoms with long ways round, and more and longer bursts.
Case make_large_case(std::uint64_t seed, const std::vector<Given>& given);
std::string print(const Case& c, const std::vector<Given>& given);

}  // namespace meld::retraction
