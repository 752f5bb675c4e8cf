// What is known of the values of int terms, as ranges.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>

#include "compiler/plan/plan.h"

namespace meld::plan {

// From least to greatest; empty where least is the greater: nothing has been derived yet.
struct Range {
    std::int64_t least = INT64_MIN, greatest = INT64_MAX;

    static Range empty() { return {INT64_MAX, INT64_MIN}; }
    bool is_empty() const { return least > greatest; }
    bool is_bounded() const { return !is_empty() && least != INT64_MIN && greatest != INT64_MAX; }
    bool operator==(const Range&) const = default;
};
Range either(const Range& a, const Range& b);
Range both(const Range& a, const Range& b);

// The possible results of an operation. A value that overflows ends the run, so the range of stored values ends at the limits of ints.
Range sum(const Range& a, const Range& b);
Range negative(const Range& a);

using KnownRanges = std::map<VariableId, Range>;
Range range_of(const Term& t, const KnownRanges& known);

// The ranges of a rule's variables, where `of` gives those of the arguments of predicates; false: the body cannot hold yet.
bool understand(const check::Program& program, const check::Rule& rule, const std::function<Range(PredicateId, std::size_t)>& of,
                KnownRanges& known);

}  // namespace meld::plan
