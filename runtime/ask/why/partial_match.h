// Rules whose heads have the arguments of a fact: what of them is then known, and what is left to be looked up.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "runtime/ask/facts/program.h"
#include "runtime/ask/query/order.h"
#include "runtime/ask/query/terms.h"

namespace meld::inspect {

// A fact that outlives the search that has found it, or what is known of one: arguments may be open.
struct Known {
    check::PredicateId predicate;
    std::optional<u64> catom = {};
    std::vector<std::optional<Value>> arguments = {};  // After the catom.
    u32 rank = kAbsent;
    std::size_t age = 0;  // The number of its state: so many ticks before.

    bool whole() const;
    std::vector<Value> values() const;
};

// A rule whose head has the arguments of a fact.
struct PartialMatch {
    const check::Rule* of = nullptr;
    check::Rule rule;                      // With variables for what the head is to be.
    std::vector<check::Clause> body = {};  // Its own, then what the head asks for.
    std::size_t own = 0;
    Values values = {};
    Bound bound = {};
    bool open = false;  // Some of the head may be anything.
};

// Nothing: the head cannot be this fact. `solve`: D + 1 that must be 7 is a D that is 6. `more`: what stands around the head, beside the
// rule's body.
std::optional<PartialMatch> match_head(const Program& program, Terms& terms, const check::Rule& rule, const check::Atom& head,
                                       const Known& fact, bool solve, const std::vector<check::Clause>& more = {});
// What a body binds outside of its parts.
void bind_by(const std::vector<check::Clause>& body, Bound& bound);
Bound bound_by(const PartialMatch& match);

// Why a term, or a body, cannot be looked up; empty: it can.
std::string cannot(const check::Program& checked, const check::Term& term);
std::string cannot(const Program& program, const std::vector<check::Clause>& body);

}  // namespace meld::inspect
