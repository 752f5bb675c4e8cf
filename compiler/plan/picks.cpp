#include "compiler/plan/picks.h"

#include <algorithm>

namespace meld::plan {

using namespace check;

namespace {

// Of a term that is a parameter: its position.
std::optional<std::size_t> parameter(const Function& function, const Term& t) {
    if (!t.is_variable() || t.variable.index() >= function.parameter_count) return std::nullopt;
    return t.variable.index();
}

}  // namespace

std::optional<Aggregate> picks(const Function& function) {
    const auto is_int = [&](const Variable& v) { return v.type == Type::Int; };
    if (function.external || function.parameter_count != 2 || function.variables.count() != 2 || function.result != Type::Int ||
        !is_int(function.variables[VariableId(0)]) || !is_int(function.variables[VariableId(1)]))
        return std::nullopt;
    const Term& body = function.body;
    const auto both = [&](const Term& a, const Term& b) {
        const auto first = parameter(function, a), second = parameter(function, b);
        return first && second && *first != *second;
    };
    if (body.op == Op::Min || body.op == Op::Max) {
        if (body.operands.size() != 2 || !both(body.operands[0], body.operands[1])) return std::nullopt;
        return body.op == Op::Min ? Aggregate::Min : Aggregate::Max;
    }
    if (body.op != Op::If || body.operands.size() != 3) return std::nullopt;
    const Term& test = body.operands[0];
    const bool less = test.op == Op::Less || test.op == Op::LessEqual, greater = test.op == Op::Greater || test.op == Op::GreaterEqual;
    if ((!less && !greater) || !both(test.operands[0], test.operands[1]) || !both(body.operands[1], body.operands[2])) return std::nullopt;
    const bool then_first = body.operands[1].variable == test.operands[0].variable;
    return less == then_first ? Aggregate::Min : Aggregate::Max;
}

std::optional<Aggregate> picks(const Plan& plan, PredicateId id) {
    const Predicate& p = plan.program.predicates[id];
    // What rides along is that of the least value, also where the greatest is kept.
    const bool alone = p.arguments.size() == p.aggregate_at + 1;
    if (p.aggregate != Aggregate::Custom || p.arguments[p.aggregate_at].type != Type::Int || !alone) return std::nullopt;
    const bool decided_at_once = std::ranges::any_of(plan.strata, [&](const StratumPlan& s) {
        const bool all_there = s.recursion == Recursion::None || s.recursion == Recursion::Tree;
        return all_there && std::ranges::find(s.predicates, id) != s.predicates.end();
    });
    return decided_at_once ? picks(plan.program.functions[p.fold]) : std::nullopt;
}

}  // namespace meld::plan
