#include "runtime/eval/repeated.h"

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

void Repeated::rest(i64 now, std::vector<u32>& awake, std::vector<u64>& dirty, const std::vector<Action>& actions, Timers& timers) {
    if (!possible_) return;
    kept_.clear();
    std::swap(values_, last_values_);
    values_.clear();
    resting_.assign(asked_.size(), 0);
    std::size_t evaluated = 0;
    for (std::size_t i = 0; i < awake.size(); ++i) {
        if (dirty[i] == kDirtyTick && asked(awake[i])) {
            set(resting_, awake[i]);
            continue;
        }
        awake[evaluated] = awake[i];
        dirty[evaluated++] = dirty[i];
    }
    awake.resize(evaluated);
    dirty.resize(evaluated);
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

void Repeated::add_to(std::vector<Action>& actions, const u64* ids) const {
    const auto middle = static_cast<std::ptrdiff_t>(actions.size());
    actions.insert(actions.end(), kept_.begin(), kept_.end());
    std::inplace_merge(actions.begin(), actions.begin() + middle, actions.end(),
                       [&](const Action& a, const Action& b) { return ids[a.catom] < ids[b.catom]; });
}

}  // namespace meld::eval
