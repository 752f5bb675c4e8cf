// A random case: a world, what is given to its catoms, and bursts of changes. Made from a seed, printed so that a failure
// can be read, and applied to a mirror that knows what the runtime should have been told.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "runtime/world/lattice/lattice.h"

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
    // Cut and Heal are for the link of two catoms that touch, or that the graph links; Join is for two nodes that it does not link. One
    // that hangs restarts after some ticks.
    enum class Kind { Give, Take, Remove, Add, Move, Cut, Heal, Join, Hang, Restart } kind = Kind::Give;
    int tick = 0;  // After the start of its burst.
    Cell cell = {};
    Cell to = {};           // Move, Cut, Heal, Join
    std::size_t given = 0;  // Give, Take: which predicate,
    Row arguments = {};     // and its arguments after the catom. Hang: for how many ticks.
    bool has_other_cell() const { return kind >= Kind::Move && kind <= Kind::Join; }
};

struct Case {
    std::uint64_t seed = 0;
    world::LatticeKind lattice = world::LatticeKind::Square;
    std::vector<Cell> cells;  // As World::cells.
    std::vector<std::vector<Change>> bursts;
    // A graph instead of a lattice: its nodes are the cells, whose number is their x, and its links are pairs of these, the lower first.
    bool graph = false;
    std::set<std::pair<std::uint64_t, std::uint64_t>> links = {};
};
inline Cell node(std::uint64_t id) { return {static_cast<std::int32_t>(id), 0, 0}; }

// What stands where and holds what, by the book.
struct Mirror {
    Mirror(const Case& c, const std::vector<Given>& given);
    // Does what the change says and returns true; false, and nothing, where it makes no sense (any more).
    bool apply(const Change& change);
    // Catoms that restart in this tick, because they have hung long enough.
    std::vector<std::uint64_t> wake(std::int64_t now);
    // In this tick a catom begins to hang.
    void hang(std::uint64_t id, std::int64_t until) { hung[id] = until; }
    void restart(std::uint64_t id);
    // The state of another mirror of the same case.
    void become(const Mirror& other);

    const std::vector<Given>& given;
    const bool graph;
    std::map<Cell, std::uint64_t> at;
    std::uint64_t next_id = 0;
    Facts facts;  // Given ones.
    // Links that are cut, the lower number first; and in which tick a catom restarts that hangs.
    std::set<std::pair<std::uint64_t, std::uint64_t>> missing = {};
    std::map<std::uint64_t, std::int64_t> hung = {};
    // In a graph: what is at the ports of each node.
    std::map<std::uint64_t, std::map<int, std::uint64_t>> ports = {};
    // Where nodes are that rules have made, in diameters. Whoever knows of them adds them here and to `at`.
    std::map<std::uint64_t, std::array<double, 3>> made = {};
    bool linked(std::uint64_t a, std::uint64_t b) const;

  private:
    bool link(std::uint64_t a, std::uint64_t b);
    int port_for(std::uint64_t from, std::uint64_t to) const;
    std::map<std::uint64_t, std::vector<std::uint64_t>> rows_ = {};  // The neighbours that the graph gives to each node, in order.
    void forget(std::uint64_t id);
    void forget_links(std::uint64_t id);
};

using Random = std::mt19937_64;
inline std::int64_t below(Random& random, std::int64_t n) { return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(n)); }

// Adds links that are cut and healed, where these are not those of a graph, and catoms that hang and restart, at random.
void add_failures(Case& c, const std::vector<Given>& given);
// Whether there are any, and any of catoms.
bool has_failures(const Case& c);
bool has_catom_failures(const Case& c);

Case make_case(std::uint64_t seed, const std::vector<Given>& given);
// A graph with up to 70 nodes and of several pieces now and then, whose nodes are killed and whose links are cut, healed and joined. No
// node ever has more links than `max_degree`.
Case make_graph_case(std::uint64_t seed, const std::vector<Given>& given, std::size_t max_degree);
// A labyrinth of more than a thousand catoms with long ways round, and more and longer bursts.
Case make_large_case(std::uint64_t seed, const std::vector<Given>& given);
std::string print(const Case& c, const std::vector<Given>& given);

}  // namespace meld::retraction
