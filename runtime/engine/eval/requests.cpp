#include "runtime/engine/eval/requests.h"

#include <utility>

#include "runtime/base/assert.h"
#include "runtime/engine/tuple/facts.h"

namespace meld::eval {

Requests::~Requests() {
    clear(next_);
    clear(current_);
}

void Requests::act(u32 catom, u16 predicate, const Value* arguments) {
    MELD_EXPECT(module_.predicates[predicate].kind == PredicateKind::Action, "predicate {}", predicate);
    next_.actions.push_back({catom, predicate, keep(predicate, arguments)});
}

// All have the same sequence number: they come before the messages of the sender's rules, and among themselves in the order of the
// requests.
void Requests::send(u32 to, u16 predicate, u64 from, const Value* arguments) {
    MELD_EXPECT(module_.predicates[predicate].kind == PredicateKind::Linear, "predicate {}", predicate);
    next_.messages.push_back({to, predicate, from, 0, keep(predicate, arguments)});
}

void Requests::begin_evaluation() {
    clear(current_);
    std::swap(next_, current_);
}

const Value* Requests::keep(u16 predicate, const Value* arguments) {
    const PredicateInfo& p = module_.predicates[predicate];
    Value* const copy = next_.values.copy(arguments, p.arity);
    for (u32 i = 0; i < p.arity; ++i) {
        const tuple::Type type = tuple::type_of(module_, p.fields[i]);
        copy[i] = columns_.lists().keep(type, arguments[i], 0);
        if (type.compound() && copy[i].list != nullptr) next_.owned.push_back(copy[i].list);
    }
    const auto [items, text] = columns_.lists().too_long(0);
    MELD_CHECK(items == 0, "a module gives {} a {} of {} {}, more than the limit", p.name, text ? "string" : "list", items,
               text ? "bytes" : "elements");
    return copy;
}

void Requests::clear(Batch& batch) {
    for (const List* list : batch.owned) columns_.lists().release(list, 0);
    batch.owned.clear();
    batch.messages.clear();
    batch.actions.clear();
    batch.values.clear();
}

}  // namespace meld::eval
