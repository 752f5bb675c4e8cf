#include "compiler/syntax/aggregates.h"

#include <algorithm>
#include <iterator>

#include "runtime/base/assert.h"

namespace meld::syntax {

namespace {

using Place = AggregateInfo::Place;
using Values = AggregateInfo::Values;
using Result = AggregateInfo::Result;
using Order = AggregateInfo::Order;
using Reduction = AggregateInfo::Reduction;
constexpr unsigned kPayload = AggregateInfo::kPayload, kAnyOrder = AggregateInfo::kAnyOrder,
                   kIntsInAnyOrder = AggregateInfo::kIntsInAnyOrder, kParameter = AggregateInfo::kParameter, kTyped = AggregateInfo::kTyped,
                   kYields = AggregateInfo::kYields;

constexpr AggregateInfo kInfos[] = {
#define MELD_AGGREGATE(kind, word, places, values, result, order, reduction, of_nothing, traits) \
    {#kind, word, Place::places, Values::values, Result::result, Order::order, Reduction::reduction, #reduction, of_nothing, traits},
#include "compiler/syntax/aggregates.def"
};

struct Word {
    std::string_view text;
    Aggregate aggregate;
};
constexpr Word kWords[] = {
#define MELD_AGGREGATE(kind, word, places, values, result, order, reduction, of_nothing, traits) {word, Aggregate::kind},
#define MELD_AGGREGATE_ALIAS(kind, word) {word, Aggregate::kind},
#include "compiler/syntax/aggregates.def"
};

template <class Fits>
Aggregate named(std::string_view word, const Fits& fits) {
    const auto* found =
        std::find_if(std::begin(kWords), std::end(kWords), [&](const Word& w) { return w.text == word && fits(info(w.aggregate)); });
    return found == std::end(kWords) ? Aggregate::Custom : found->aggregate;
}

template <class Fits>
std::vector<std::string> words(const Fits& fits) {
    std::vector<std::string> out;
    for (const Word& w : kWords)
        if (fits(info(w.aggregate))) out.emplace_back(w.text);
    std::sort(out.begin(), out.end());
    return out;
}

}  // namespace

const AggregateInfo& info(Aggregate aggregate) {
    const auto index = static_cast<std::size_t>(aggregate);
    MELD_CHECK(index < std::size(kInfos), "there is no aggregate number {}", index);
    return kInfos[index];
}

Aggregate declared_aggregate(std::string_view word) {
    return named(word, [](const AggregateInfo& i) { return i.declared(); });
}
Aggregate aggregate_of_matches(std::string_view word) {
    return named(word, [](const AggregateInfo& i) { return i.of_matches(); });
}
std::vector<std::string> words_of_declared_aggregates() {
    return words([](const AggregateInfo& i) { return i.declared(); });
}
std::vector<std::string> words_of_aggregates_of_matches() {
    return words([](const AggregateInfo& i) { return i.of_matches(); });
}

}  // namespace meld::syntax
