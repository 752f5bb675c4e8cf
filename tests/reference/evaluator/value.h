// Values and facts as the reference evaluator knows them.
#pragma once

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstdint>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "compiler/check/program/program.h"

namespace meld::reference {

using check::PredicateId;
using check::Program;

struct Value;
using Values = std::vector<Value>;

// Lists, sets, arrays, structs, tuples and vec3 are their items; a set has each once, in order.
struct Value {
    std::variant<std::int64_t, double, std::string, Values> is = std::int64_t{0};  // Int, Bool and Node; Float; String.

    std::int64_t integer() const { return std::get<std::int64_t>(is); }
    double real() const { return std::get<double>(is); }
    const std::string& text() const { return std::get<std::string>(is); }
    const Values& items() const { return std::get<Values>(is); }
    bool is_real() const { return std::holds_alternative<double>(is); }
    bool is_text() const { return std::holds_alternative<std::string>(is); }
    bool has_items() const { return std::holds_alternative<Values>(is); }
    bool truth() const { return integer() != 0; }
    // Numbers as numbers, strings by bytes, all else by items, a prefix before what it begins.
    bool operator==(const Value& other) const;
    std::partial_ordering operator<=>(const Value& other) const;
};
inline Value value_of(std::int64_t integer) { return {integer}; }
inline Value value_of(bool truth) { return {std::int64_t{truth}}; }
inline Value value_of(double real) { return {real}; }
inline Value value_of(Values items) { return {std::move(items)}; }

// The catom first.
using Row = Values;
using Rows = std::set<Row>;
using Bag = std::multiset<Row>;
// By PredicateId.
using Facts = std::vector<Rows>;

// Whether every float in it is a number that is not infinite: no other enters a fact.
inline bool is_finite(const Value& v) {
    if (v.has_items()) return std::all_of(v.items().begin(), v.items().end(), [](const Value& item) { return is_finite(item); });
    return !v.is_real() || std::isfinite(v.real());
}
inline bool is_real(const check::Type& type) { return type == check::Type::Float; }

// As a program could write it.
std::string print(const check::Type& type, const Value& value);
std::string print(const Program& program, PredicateId predicate, const Row& row);

// The rows of one catom, as a range [first, second).
template <class Container>
auto at_catom(const Container& rows, std::int64_t catom) {
    return std::pair(rows.lower_bound(Row{value_of(catom)}), rows.lower_bound(Row{value_of(catom + 1)}));
}

}  // namespace meld::reference
