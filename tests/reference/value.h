// Values and facts as the reference evaluator knows them.
#pragma once

#include <compare>
#include <cstdint>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "compiler/check/program.h"

namespace meld::reference {

using check::PredicateId;
using check::Program;

struct Value {
    std::variant<std::int64_t, double> is = std::int64_t{0};  // Int, Bool and Node; Float.

    std::int64_t integer() const { return std::get<std::int64_t>(is); }
    double real() const { return std::get<double>(is); }
    bool is_real() const { return std::holds_alternative<double>(is); }
    bool truth() const { return integer() != 0; }
    auto operator<=>(const Value&) const = default;
};
inline Value value_of(std::int64_t integer) { return {integer}; }
inline Value value_of(bool truth) { return {std::int64_t{truth}}; }
inline Value value_of(double real) { return {real}; }

// The catom first.
using Row = std::vector<Value>;
using Rows = std::set<Row>;
using Bag = std::multiset<Row>;
// By PredicateId.
using Facts = std::vector<Rows>;

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
