// What an evaluation begins with, the agenda, and the order of what it leaves: messages and actions.
#include <algorithm>
#include <tuple>

#include "runtime/base/assert.h"
#include "runtime/eval/evaluator.h"
#include "runtime/tuple/field.h"

namespace meld::eval {

void Evaluator::resize(std::size_t catoms) {
    for (Agenda& agenda : agendas_) agenda.resize(catoms);
}

// The agenda of this tick is taken as a whole, and marks go to the other one.
void Evaluator::take_agenda(const Geometry& geometry) {
    taken().clear();
    next_agenda_ = 1 - next_agenda_;
    if (acts_ || left_out_) leave_out_or_postpone(geometry);
    groups_.clear();
    taken().each_group([&](u32 group) { groups_.push_back(group); });
}

void Evaluator::leave_out_or_postpone(const Geometry& geometry) {
    taken().each([&](u32 catom, u64 dirty) {
        const bool out = geometry.catom_state[catom] != kCatomOwned || (left_out_ && left_out_(catom));
        if (!out && (!acts_ || acts_(catom))) return;
        taken().forget(catom);
        if (!out) agenda().mark(catom, dirty);
    });
}

void Evaluator::order_actions(const Geometry& geometry) {
    std::ranges::stable_sort(actions_, {}, [&](const Action& action) { return id_of(geometry, action.catom); });
}

Sent Evaluator::all_sent(const Geometry& geometry) const {
    Sent all{.messages = messages_, .values = {}};
    std::vector<Value> arguments;
    for (const u16 predicate : linear_predicates_) {
        const PredicateInfo& p = module_.predicates[predicate];
        each_sent(p.column, [&](SentRow sent, const u8* row) {
            tuple::read_row(p, row, arguments);
            all.messages.push_back({sent.to, predicate, id_of(geometry, sent.from), 0, all.values.copy(arguments.data(), p.arity)});
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
