// The costs of the join order.
#include "compiler/plan/access.h"

#include <algorithm>

#include "runtime/module/abi/senses.h"

namespace meld::plan {

using namespace check;

namespace {

// The cost of an access. Only the order of the numbers matters: each new variable adds 1 to an access that may find several facts or whose
// test may fail, so that of two similar ones the one with more known arguments comes first. The gaps leave room for 4 such variables.
//
//                                            at the     at a neighbour   at a neighbour
//                                            site       already found    whose id is known
//   one fact, in a record or the geometry      10           15                35
//   a row whose group is known, a lookup       20           25                35
//   all rows                                   40           50                35
//
// The last column is one number, because the search for the neighbour comes first and fails for most ids.
struct SiteCosts {
    int one, lookup, rows;
};
constexpr SiteCosts kAtSite{.one = 10, .lookup = 20, .rows = 40};
constexpr SiteCosts kAtFoundNeighbour{.one = 15, .lookup = 25, .rows = 50};
constexpr int kAtNamedNeighbour = 35;
// Of rows at the site of which some arguments are known, those that are there from the start are read before those that are still being
// derived, even if they have one more new variable: these become more, and are looked up where all of them is known by then.
constexpr int kStaysAsItIs = 2;
// Walking along a list takes no further memory; it multiplies the later steps like the rows of a predicate.
constexpr int kElements = 42;
// Links: the port of a neighbour that has been found is known; a neighbour whose id is known is searched at each port; and visiting each
// neighbour multiplies the later steps by up to kMaxPorts.
constexpr int kFoundLink = 5;
constexpr int kNamedLink = 30;
constexpr int kEachLink = 60;
// A route that points to the execution site: all neighbours are asked for their rows.
constexpr int kEachNeighbourThatPointsHere = 70;

// Predicates of the world that hold for several values at a catom. They are read from the geometry at no more than kMaxPorts places, or
// searched in a table, so they cost as much as one fact.
bool several_in_world(WorldSource world) { return info(world).facts == SenseInfo::Facts::Several; }

}  // namespace

bool Known::has(const Term& term) const {
    return all_free(term, [&](VariableId v) { return has(v); });
}

bool AccessPlanner::is_link(const Atom& atom) const { return meld::is_link(plan_.program.predicates[atom.predicate].world); }

bool AccessPlanner::reads(const Clause& clause) {
    return clause.kind != Clause::Kind::Test && clause.kind != Clause::Kind::Not && clause.kind != Clause::Kind::Aggregate;
}

std::optional<Access> AccessPlanner::access(const Clause& clause, const Known& known) const {
    if (!reads(clause)) return std::nullopt;
    // The list whose elements are read, or the bound of a change.
    if (clause.kind != Clause::Kind::Atom && !known.has(clause.test)) return std::nullopt;
    if (clause.kind == Clause::Kind::Element) return Access{.reason = Reason::Elements, .cost = kElements};
    return is_link(clause.atom) ? of_link(clause.atom, known) : of_atom(clause.atom, known);
}

std::optional<Access> AccessPlanner::of_link(const Atom& atom, const Known& known) const {
    for (std::size_t i = 1; i < atom.arguments.size(); ++i)
        if (const Term& t = atom.arguments[i]; !t.is_variable() && t.op != Op::Anonymous && !known.has(t)) return std::nullopt;
    const bool forward = atom.arguments[0].variable == rule_.site;
    const Term& other = atom.arguments[forward ? 1 : 0];
    if (other.is_variable() && known.places.contains(other.variable))
        return Access{.reason = Reason::Named, .link = Reason::Named, .cost = kFoundLink};
    if (other.is_variable() && known.values.contains(other.variable))
        return Access{.reason = Reason::Named, .link = Reason::Named, .cost = kNamedLink};
    return Access{.reason = Reason::Links, .link = Reason::Links, .cost = kEachLink};
}

std::optional<Access> AccessPlanner::of_atom(const Atom& atom, const Known& known) const {
    const Predicate& p = plan_.program.predicates[atom.predicate];
    MELD_EXPECT(atom.arguments.size() == p.arguments.size(), "rule {}: {}", rule_.name, p.signature());
    std::size_t new_variables = 0, open = 0, open_in_group = 0;
    for (std::size_t i = 1; i < atom.arguments.size(); ++i) {
        const Term& t = atom.arguments[i];
        const bool is_new = t.is_variable() && !known.has(t.variable);
        if (!t.is_variable() && t.op != Op::Anonymous && !known.has(t)) return std::nullopt;
        new_variables += is_new ? 1 : 0;
        open += is_new || t.op == Op::Anonymous ? 1 : 0;
        if (i <= group_arguments(p)) open_in_group = open;
    }
    const Storage storage = plan_.of(atom.predicate).storage;
    const bool record = storage == Storage::Flag || storage == Storage::Single || storage == Storage::World;
    Access out;
    out.known = atom.arguments.size() - 1 - open;
    // A known group has at most one row, which is looked up.
    out.reason = open == 0                                                      ? Reason::Test
                 : new_variables == 0                                           ? Reason::Exists
                 : (record && !several_in_world(p.world)) || open_in_group == 0 ? Reason::One
                                                                                : Reason::Rows;
    const int each_new = static_cast<int>(new_variables);
    const auto at = [&](const SiteCosts& costs) {
        return record ? costs.one + each_new : new_variables == 0 || open_in_group == 0 ? costs.lookup : costs.rows + each_new;
    };
    const VariableId place = atom.arguments[0].variable;
    if (place == rule_.site) {
        const bool stays = !growing_.empty() && std::ranges::find(growing_, atom.predicate) == growing_.end();
        out.cost = at(kAtSite) - (stays && out.reason == Reason::Rows && out.known > 0 ? kStaysAsItIs : 0);
    } else if (known.places.contains(place)) {
        out.cost = at(kAtFoundNeighbour);
    } else if (known.values.contains(place)) {
        out.link = Reason::Named;
        out.cost = kAtNamedNeighbour + each_new;
    } else {
        // Nothing is known about this catom: it must be a neighbour that points here; all neighbours are tried.
        const bool points_here =
            p.route && atom.arguments.size() > 1 && atom.arguments[1].is_variable() && atom.arguments[1].variable == rule_.site;
        if (!points_here) return std::nullopt;
        out.cost = kEachNeighbourThatPointsHere;
    }
    MELD_ENSURE(out.cost > 0 && out.known < atom.arguments.size());
    return out;
}

}  // namespace meld::plan
