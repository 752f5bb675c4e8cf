// What a rule produces at the end of its steps; each kind of head is a small struct with the concrete syntax in which --emit=plan prints
// it.
#pragma once

#include <utility>
#include <variant>
#include <vector>

#include "compiler/plan/steps.h"

namespace meld::plan {

struct HeadPlan;

// -> dist(B, D + 1)                       a fact, a message or an action
struct MakeFact {
    PredicateId predicate = {};
    VariableId place = {};
    std::vector<Term> arguments = {};           // After the catom.
    std::vector<VariableId> contributors = {};  // As of the rule.
    bool alike = false;                         // In a comprehension: the same for all receivers (letters.cpp),
    std::string difference = {};                // or why it is written for each of them.
};

// -> for all                              the heads, for each way to satisfy the steps
//      dist(B, D)
//        -> seen(A, D)
struct ForAll {
    std::vector<Step> steps = {};
    std::vector<HeadPlan> heads;
};

// -> for all                              the same; then the results of all ways, and once the last heads
//      dist(B, D)
//    S = sum D
// -> total(A, S)
struct AggregateAll {
    ForAll each;
    std::vector<check::HeadAggregate> aggregates = {};
    std::vector<HeadPlan> results;
};

// -> if D > 3
//      -> far(A)
//    else
//      -> near(A)
struct Choose {
    Term condition = {};
    std::vector<HeadPlan> heads;
    std::vector<HeadPlan> others;
};

// -> D = X + 1                            a value for the heads
//      -> dist(A, D)
struct With {
    VariableId variable = {};
    Term value = {};
    std::vector<HeadPlan> heads;
};

struct HeadPlan {
    std::variant<MakeFact, ForAll, AggregateAll, Choose, With> what;
};

// The head as a T, or null.
template <class T>
const T* as(const HeadPlan& head) {
    return std::get_if<T>(&head.what);
}
template <class T>
T* as(HeadPlan& head) {
    return std::get_if<T>(&head.what);
}

template <class AnyHead, class... F>
void visit_head(AnyHead& head, F&&... functions) {
    std::visit(Overloaded{std::forward<F>(functions)...}, head.what);
}

// Every head, including those inside others: visit(const HeadPlan&).
template <class Visit>
void each_head_plan(const std::vector<HeadPlan>& heads, const Visit& visit) {
    for (const HeadPlan& h : heads) {
        visit(h);
        visit_head(
            h, [](const MakeFact&) {}, [&](const ForAll& all) { each_head_plan(all.heads, visit); },
            [&](const AggregateAll& all) {
                each_head_plan(all.each.heads, visit);
                each_head_plan(all.results, visit);
            },
            [&](const Choose& choose) {
                each_head_plan(choose.heads, visit);
                each_head_plan(choose.others, visit);
            },
            [&](const With& with) { each_head_plan(with.heads, visit); });
    }
}

// The one fact of a comprehension that goes to all neighbours alike, or null. Known after the letters.
inline const MakeFact* to_all_neighbours(const ForAll& h) {
    if (h.steps.size() != 1 || h.heads.size() != 1) return nullptr;
    const EachNeighbour* each = as<EachNeighbour>(h.steps[0]);
    const MakeFact* fact = as<MakeFact>(h.heads[0]);
    const bool all = each != nullptr && each->place.valid() && !each->port.bind.valid() && each->port.equals.op == check::Op::Anonymous;
    return all && fact != nullptr && fact->alike && fact->place == each->place ? fact : nullptr;
}

// The steps for which a head repeats its inner heads; null for all other heads.
inline const std::vector<Step>* steps_of(const HeadPlan& head) {
    if (const ForAll* all = as<ForAll>(head)) return &all->steps;
    if (const AggregateAll* all = as<AggregateAll>(head)) return &all->each.steps;
    return nullptr;
}

}  // namespace meld::plan
