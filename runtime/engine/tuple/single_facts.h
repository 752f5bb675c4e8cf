// Facts of a predicate that has at most one at a catom, each a number or none: without a call or memory for each of them.
#pragma once

#include "runtime/engine/tuple/columns.h"
#include "runtime/engine/tuple/field.h"
#include "runtime/engine/tuple/values.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::tuple {

class SingleFacts {
  public:
    // Of predicates that are stored so, and whose arguments are single words.
    static bool fits(const PredicateInfo& p) {
        if (p.column == kNone16 || (p.storage != Storage::Flag && p.storage != Storage::Single)) return false;
        for (u32 i = 0; i < p.arity; ++i)
            if (p.fields[i].type >= ValueType::String) return false;
        return true;
    }
    // The columns must stay as they are.
    SingleFacts(const ModuleInfo& module, const Columns& columns, u32 predicate)
        : p_(module.predicates[predicate]), records_(columns.pointers()[p_.column]), stride_(module.columns[p_.column].stride) {}

    // The record of a catom that has a fact; null without.
    const u8* find(u32 catom) const {
        const u8* const record = records_ + std::size_t{catom} * stride_;
        return is_present(p_, record) ? record : nullptr;
    }
    Value argument(const u8* record, u32 i) const { return load_field(p_.fields[i], record); }
    // As hash_arguments().
    u64 hash(u64 start, const u8* record) const {
        for (u32 i = 0; i < p_.arity; ++i) start = hash_combine(start, normal(p_.fields[i].type, argument(record, i)).catom);
        return start;
    }

  private:
    const PredicateInfo& p_;
    const u8* records_;
    std::size_t stride_;
};

}  // namespace meld::tuple
