// Expressions of a checked rule under given values of its variables.
#pragma once

#include <optional>

#include "tests/reference/trials/scene.h"

namespace meld::reference {

// A tick lasts so long unless the world says otherwise, and no world of a test does.
constexpr double kTick_seconds = 1e-3;

// By VariableId: what is bound.
using Environment = std::vector<std::optional<Value>>;

bool all_bound(const check::Term& term, const Environment& env);

// The value of a term whose variables are all bound. Nothing: an arithmetic error, which stops a run: overflow, division by
// zero, a conversion that has no result.
std::optional<Value> evaluate(const Scene& scene, const check::Term& term, const Environment& env);

// What a function of the program gives.
std::optional<Value> call(const Scene& scene, check::FunctionId function, const Values& arguments);

// What an aggregate makes of values in this order.
struct Folded {
    bool failed = false;
    std::optional<Value> value = {};  // Nothing: there were no values, and no first to start from.
};
struct FoldRule {
    check::Aggregate aggregate = check::Aggregate::None;
    check::Type type = check::Type::Int;  // Of a value.
    check::FunctionId function = {};      // Custom,
    std::optional<Value> parameter = {};  // and where it starts; of MinK and MaxK, how many values they keep.
};
// The sum of two values; lists of floats and vectors element by element, as long as both have one. Nothing: an overflow.
std::optional<Value> added(const Value& a, const Value& b);
// The mean of ints or floats, of which there are some.
double mean(const Values& values);
// The `limit` least values from the least on, or the greatest from the greatest on.
Values best_of(Values values, std::int64_t limit, bool least);
Folded fold(const Scene& scene, const FoldRule& rule, const Values& values);

}  // namespace meld::reference
