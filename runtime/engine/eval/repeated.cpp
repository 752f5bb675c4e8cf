#include "runtime/engine/eval/repeated.h"

#include <algorithm>
#include <utility>

namespace meld::eval {

Repeated::Repeated(const ModuleInfo& module) : module_(module) {
    // Where rules read the tick, each evaluation may say something else. The lists among the arguments belong to the evaluation.
    const auto is_list = [](const FieldInfo& f) { return f.type >= ValueType::String; };
    bool any = false, lists = false;
    for (u32 i = 0; i < module.predicate_count; ++i) {
        const PredicateInfo& p = module.predicates[i];
        if (!p.repeats) continue;
        any = true;
        lists = lists || std::any_of(p.fields, p.fields + p.arity, is_list);
    }
    possible_ = any && !lists && !module.reads_tick;
}

void Repeated::rest(i64 now, Agenda& agenda, const std::vector<Action>& actions, Timers& timers) {
    if (!possible_) return;
    kept_.clear();
    std::swap(values_, last_values_);
    values_.clear();
    resting_.assign(asked_.size(), 0);
    agenda.each([&](u32 catom, u64 dirty) {
        if (dirty != kDirtyTick || !asked(catom)) return;
        set(resting_, catom);
        agenda.forget(catom);
    });
    for (const Action& a : actions) {
        const PredicateInfo& p = module_.predicates[a.predicate];
        if (!p.repeats || !has(resting_, a.catom)) continue;
        // The actions of a catom stand together.
        if (kept_.empty() || kept_.back().catom != a.catom) timers.add(now, now + 1, a.catom, kDirtyTick);
        kept_.push_back({a.catom, a.predicate, values_.copy(a.arguments, p.arity)});
    }
    asked_ = resting_;
}

void Repeated::note(const Action& action) {
    if (possible_ && module_.predicates[action.predicate].repeats) set(asked_, action.catom);
}

void Repeated::add_to(std::vector<Action>& actions, const Geometry& geometry) const {
    const auto middle = static_cast<std::ptrdiff_t>(actions.size());
    actions.insert(actions.end(), kept_.begin(), kept_.end());
    std::inplace_merge(actions.begin(), actions.begin() + middle, actions.end(),
                       [&](const Action& a, const Action& b) { return id_of(geometry, a.catom) < id_of(geometry, b.catom); });
}

}  // namespace meld::eval
