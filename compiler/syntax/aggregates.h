// The aggregates of the language, from the table aggregates.def.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace meld::syntax {

enum class Aggregate {
#define MELD_AGGREGATE(kind, word, places, values, result, order, reduction, of_nothing, traits) kind,
#include "compiler/syntax/aggregates.def"
};

// The table's entry for an aggregate; aggregates.def explains each column.
struct AggregateInfo {
    enum class Place { Nowhere, Declared, Matches, Both };
    enum class Values { Any, Ordered, Summable, Counted, Sets, Lists, Reals, Bools, Elements };
    enum class Result { Same, Int, Float, ListOf };
    enum class Order { None, Least, Greatest };
    enum class Reduction { Set, Best, First, Since, Combine, CombineInOrder };
    enum Trait : unsigned { kPayload = 1, kAnyOrder = 2, kIntsInAnyOrder = 4, kParameter = 8, kTyped = 16, kYields = 32 };

    std::string_view kind;  // Its name in C++: the kernel's template is `kindOf`.
    std::string_view word;
    Place place = Place::Nowhere;
    Values values = Values::Any;
    Result result = Result::Same;
    Order order = Order::None;
    Reduction reduction = Reduction::Set;
    std::string_view reduction_name;  // As meld::Reduce names it.
    std::string_view of_nothing;
    unsigned traits = 0;

    bool has(Trait trait) const { return (traits & trait) != 0; }
    bool declared() const { return place == Place::Declared || place == Place::Both; }
    bool of_matches() const { return place == Place::Matches || place == Place::Both; }
};
const AggregateInfo& info(Aggregate aggregate);

// The aggregate with this word in a declaration, or over matches: in a body or a rule aggregate. Custom: the table has none.
Aggregate declared_aggregate(std::string_view word);
Aggregate aggregate_of_matches(std::string_view word);
// Their words in alphabetical order.
std::vector<std::string> words_of_declared_aggregates();
std::vector<std::string> words_of_aggregates_of_matches();

// Whether it is computed from all derivations, not from one of them.
inline bool combines(Aggregate a) {
    return info(a).reduction == AggregateInfo::Reduction::Combine || info(a).reduction == AggregateInfo::Reduction::CombineInOrder;
}
// Whether it keeps the best of its values in an order.
inline bool keeps_best(Aggregate a) { return info(a).order != AggregateInfo::Order::None; }
inline bool keeps_least(Aggregate a) { return info(a).order == AggregateInfo::Order::Least; }
inline bool keeps_greatest(Aggregate a) { return info(a).order == AggregateInfo::Order::Greatest; }

}  // namespace meld::syntax
