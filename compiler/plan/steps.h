// The steps of a rule's body, each a small struct with the concrete syntax in which --emit=plan prints it.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "compiler/check/program/program.h"

namespace meld::plan {

using check::PredicateId;
using check::RuleId;
using check::Term;
using check::VariableId;
using check::Variables;

// Why a step reads at this point and not earlier or later. The join order decides by it, and --explain-rules prints it.
enum class Reason {
    Written,   // In the order of the text, which linear rules mean.
    Test,      // All arguments are known.
    Exists,    // Gives no variable a value.
    One,       // At most one fact.
    Rows,      // Several facts, more the fewer arguments are known.
    Elements,  // The elements of a known list or set.
    Named,     // A neighbour whose id is known.
    Links,     // Each neighbour.
};
struct Choice {
    Reason reason = Reason::Written;
    std::size_t known = 0;  // Rows: how many arguments after the catom are known.
    // Clauses that come before this one in the rule: an invalid id stands for the elements of a list or set.
    std::vector<PredicateId> dearer = {};   // They could be read and cost more.
    std::vector<PredicateId> waiting = {};  // They need variables that are not known yet.
};

// What reading a fact does with each of its arguments after the catom.
enum class ArgumentUse {
    Skip,     // `_`
    Bind,     // X: a variable gets its value here.
    Compare,  // =X: it must equal what is known already.
};

// `at port P`, after a step that goes to a neighbour.
struct PortUse {
    VariableId bind = {};          // Gets the port, if valid.
    Term equals = {};              // The port must equal this, unless it is Anonymous.
    bool from_other_side = false;  // The port is the one at which the neighbour sees the execution site.
};

struct Step;

// for each neighbour B [at port P]
struct EachNeighbour {
    VariableId place = {};  // The neighbour; invalid if no variable names it.
    Term only = {};         // Without a place: only the neighbour with this id, unless it is Anonymous.
    PortUse port = {};
    Choice choice = {};
};

// find neighbour B [at port P]            B's id is known, or B has been found and its port is needed
struct FindNeighbour {
    VariableId place = {};
    PortUse port = {};
    Choice choice = {};
};

// How a Match finds its facts among the rows at the catom, where it does not know a whole group (passes/indexes.cpp).
struct Lookup {
    enum class Kind {
        Scan,    // All rows, one after the other.
        Prefix,  // Rows are sorted: those that begin with known arguments follow each other.
        Index,   // A hash table of rows by known arguments.
        Rounds,  // The same, of a set that grows in rounds while it is evaluated: its rows are not in order yet.
        Alike,   // Changed rows of such a set: those that agree in some arguments follow each other, and are joined once.
    };
    Kind kind = Kind::Scan;
    std::vector<std::size_t> by = {};  // These arguments after the catom, counted from 1. Alike: only the head reads the others.
    std::string obstacle = {};         // Scan: why, if arguments are known.

    bool found() const { return kind != Kind::Scan && kind != Kind::Alike; }
};

// [changed] dist(A, =B, D)  [rank]        one of the facts of a predicate at a catom
struct Match {
    PredicateId predicate = {};
    VariableId place = {};             // The catom where it is read.
    bool at_site = true;               // That is the rule's execution site.
    std::vector<Term> arguments = {};  // After the catom.
    std::vector<ArgumentUse> uses = {};
    bool read_only = false;  // A linear fact that is read and not consumed.
    bool ranks = false;      // The rank of the head is above the rank of this fact.
    bool changed = false;    // Only rows that have changed, both the old and the new ones.
    Choice choice = {};
    Lookup lookup = {};
};

// if D > 3
struct Test {
    Term condition = {};
};

// D = X + 1
struct Set {
    VariableId variable = {};
    Term value = {};
};

// unless                                  none of the ways to satisfy the steps exists
//   dist(B, D)
struct Unless {
    std::vector<Step> steps;
};

// for each E in L
struct EachElement {
    VariableId variable = {};
    VariableId position = {};  // The index of the element, from 0, if valid.
    Term list = {};
    Choice choice = {};
};

// S = sum X over                          the aggregate of X over all ways to satisfy the steps
//   dist(B, X)
struct AggregateOver {
    VariableId variable = {};
    check::Aggregate aggregate = check::Aggregate::None;
    check::FunctionId function = {};  // Custom
    Term parameter = {};              // As check::Clause::parameter.
    Term value = {};                  // The value of one match; Anonymous for a count.
    std::vector<Step> steps;
};

// if delta X > e                          the fact matched last, of p(A, X), against what held before the tick
struct ChangeSince {
    PredicateId predicate = {};
    std::vector<Term> arguments = {};  // After the catom.
    VariableId variable = {};
    check::Op compare = check::Op::Greater;
    Term bound = {};
};

struct Step {
    std::variant<EachNeighbour, FindNeighbour, Match, Test, Set, Unless, EachElement, AggregateOver, ChangeSince> what;
};

// The step as a T, or null.
template <class T>
const T* as(const Step& step) {
    return std::get_if<T>(&step.what);
}
template <class T>
T* as(Step& step) {
    return std::get_if<T>(&step.what);
}

// A visitor of steps from one function for each kind.
template <class... F>
struct Overloaded : F... {
    using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;
template <class Result = void, class AnyStep, class... F>
Result visit_step(AnyStep& step, F&&... functions) {
    return std::visit<Result>(Overloaded{std::forward<F>(functions)...}, step.what);
}

// The steps inside a negation or an aggregate; null for all others.
template <class AnyStep>
auto inner_steps(AnyStep& step) -> decltype(&std::get<Unless>(step.what).steps) {
    if (auto* unless = as<Unless>(step)) return &unless->steps;
    if (auto* over = as<AggregateOver>(step)) return &over->steps;
    return nullptr;
}
// Why it reads where it does; null for a step that only tests or computes.
template <class AnyStep>
auto choice_of(AnyStep& step) -> decltype(&std::get<Match>(step.what).choice) {
    if (auto* match = as<Match>(step)) return &match->choice;
    if (auto* each = as<EachNeighbour>(step)) return &each->choice;
    if (auto* find = as<FindNeighbour>(step)) return &find->choice;
    if (auto* element = as<EachElement>(step)) return &element->choice;
    return nullptr;
}

// Every step, including those inside others: visit(const Step&).
template <class Visit>
void each_step(const std::vector<Step>& steps, const Visit& visit) {
    for (const Step& s : steps) {
        visit(s);
        if (const auto* inner = inner_steps(s)) each_step(*inner, visit);
    }
}

// The terms and variables of a step, without those of the steps inside: on_term(Term&), on_variable(VariableId&).
template <class AnyStep, class OnTerm, class OnVariable>
void each_part(AnyStep& step, const OnTerm& on_term, const OnVariable& on_variable) {
    const auto port = [&](auto& p) {
        on_variable(p.bind);
        on_term(p.equals);
    };
    visit_step(
        step,
        [&](decltype(std::get<EachNeighbour>(step.what)) s) {
            on_variable(s.place);
            on_term(s.only);
            port(s.port);
        },
        [&](decltype(std::get<FindNeighbour>(step.what)) s) {
            on_variable(s.place);
            port(s.port);
        },
        [&](decltype(std::get<Match>(step.what)) s) {
            on_variable(s.place);
            for (auto& t : s.arguments) on_term(t);
        },
        [&](decltype(std::get<Test>(step.what)) s) { on_term(s.condition); },
        [&](decltype(std::get<Set>(step.what)) s) {
            on_variable(s.variable);
            on_term(s.value);
        },
        [&](decltype(std::get<Unless>(step.what))) {},
        [&](decltype(std::get<EachElement>(step.what)) s) {
            on_variable(s.variable);
            on_variable(s.position);
            on_term(s.list);
        },
        [&](decltype(std::get<AggregateOver>(step.what)) s) {
            on_variable(s.variable);
            on_term(s.parameter);
            on_term(s.value);
        },
        [&](decltype(std::get<ChangeSince>(step.what)) s) {
            on_variable(s.variable);
            for (auto& t : s.arguments) on_term(t);
            on_term(s.bound);
        });
}

// Calls change(VariableId&) on every variable of a step, those of the steps inside too.
template <class Change>
void rewrite_variables(Step& step, const Change& change) {
    each_part(step, [&](Term& t) { check::rewrite_variables(t, change); }, change);
    if (auto* inner = inner_steps(step))
        for (Step& s : *inner) rewrite_variables(s, change);
}

}  // namespace meld::plan
