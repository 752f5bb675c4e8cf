// Turns the clauses of one body into steps: known clauses first, then the cheapest.
#pragma once

#include <vector>

#include "compiler/plan/access.h"
#include "compiler/plan/join/open_body.h"

namespace meld::plan {

class BodyOrder {
  public:
    // `ranked`: the predicates whose facts have ranks that count for the head's rank; `growing`: as of AccessPlanner.
    BodyOrder(const Plan& plan, const check::Rule& rule, std::vector<PredicateId> ranked = {}, std::vector<PredicateId> growing = {})
        : plan_(plan), program_(plan.program), rule_(rule), ranked_(std::move(ranked)), accesses_(plan, rule, std::move(growing)) {}

    // What is known before anything has been read.
    Known start() const;

    // Steps for the whole body, given what is known; `outside` are variables that clauses outside bind or use.
    std::vector<Step> order(std::vector<check::Clause> body, Known& known, Reading reading, const Variables& outside) const;
    // Steps that read the changed rows of the clause `first`, an atom, and then everything that follows from them without another read.
    // These clauses leave the body.
    std::vector<Step> start_changed(std::vector<check::Clause>& body, std::size_t first, const Variables& outside, Known& known) const;

  private:
    bool take_ready(OpenBody& body, Known& known, std::vector<Step>& steps) const;
    bool take_test(const Term& test, Known& known, std::vector<Step>& steps) const;
    bool take_nested(const check::Clause& clause, const OpenBody& body, Known& known, std::vector<Step>& steps) const;
    bool bind_equal(const Term& test, Known& known, std::vector<Step>& steps) const;
    bool take_apart(const Term& equality, Known& known, std::vector<Step>& steps) const;

    void read(const check::Clause& clause, const Choice& why, Reading reading, Known& known, std::vector<Step>& steps) const;

    void reach(VariableId place, Known& known, std::vector<Step>& steps) const;
    void atom(const check::Atom& a, Known& known, std::vector<Step>& steps) const;
    void link(const check::Atom& a, Known& known, std::vector<Step>& steps) const;
    PortUse port_of(const check::Atom& link, bool forward, Known& known) const;
    void elements(const check::Clause& c, Known& known, std::vector<Step>& steps) const;

    const Plan& plan_;
    const check::Program& program_;
    const check::Rule& rule_;
    std::vector<PredicateId> ranked_;
    AccessPlanner accesses_;
};

}  // namespace meld::plan
