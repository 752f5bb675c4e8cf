// The linear facts that were sent in a tick, in the order in which they are delivered and shown.
#include <algorithm>
#include <tuple>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/radix_sort.h"
#include "runtime/engine/eval/evaluator.h"
#include "runtime/engine/tuple/field.h"

namespace meld::eval {

bool Evaluator::sent_rows(u16 column) const {
    return std::ranges::any_of(outboxes_, [&](const Outbox* outbox) { return outbox->count(column) > 0; });
}

void Evaluator::hand_over_lists(u16 column, std::vector<tuple::Arena>& with) {
    with.resize(outboxes_.size());
    for (std::size_t i = 0; i < outboxes_.size(); ++i) std::swap(outboxes_[i]->lists(column), with[i]);
}

Sent Evaluator::all_sent(const Geometry& geometry) const {
    Sent all{.messages = messages_, .values = {}};
    std::vector<Value> arguments;
    for (const u16 predicate : linear_predicates_) {
        const PredicateInfo& p = module_.predicates[predicate];
        each_sent(p.column, [&](u32 to, u32 from, const u8* row) {
            tuple::read_row(p, row, arguments);
            all.messages.push_back({to, predicate, id_of(geometry, from), 0, all.values.copy(arguments.data(), p.arity)});
        });
    }
    std::ranges::stable_sort(all.messages, {}, [](const Message& m) { return std::pair(m.to, m.from); });
    return all;
}

// By receiver, then sender, then sequence number: each receiver has few, so the rest is sorted by insertion.
void Evaluator::order_messages() {
    order_.clear();
    for (u32 i = 0; i < unsorted_.size(); ++i) order_.push_back({unsorted_[i].to, i});
    sort_by_key(order_, spare_);
    messages_.clear();
    messages_.reserve(unsorted_.size());
    std::size_t first = 0;
    for (const Keyed& k : order_) {
        const Message& m = unsorted_[k.place];
        if (first < messages_.size() && messages_[first].to != m.to) first = messages_.size();
        std::size_t at = messages_.size();
        messages_.push_back(m);
        for (; at > first && std::tie(m.from, m.sequence) < std::tie(messages_[at - 1].from, messages_[at - 1].sequence); --at)
            messages_[at] = messages_[at - 1];
        messages_[at] = m;
    }
    MELD_ENSURE(messages_.size() == unsorted_.size(), "{} messages of {}", messages_.size(), unsorted_.size());
}

}  // namespace meld::eval
