#include "tests/reference/trials/found.h"

#include <optional>

#include "runtime/engine/tuple/facts.h"
#include "runtime/engine/tuple/values.h"

namespace meld::reference {

namespace {

Value value_at(tuple::Type type, meld::Value v) {
    if (type.kind() == ValueType::String)
        return {v.list == nullptr ? std::string() : std::string(reinterpret_cast<const char*>(v.list->items), v.list->count)};
    if (!type.compound()) return type.kind() == ValueType::Float ? value_of(v.real) : value_of(v.integer);
    Values items;
    for (std::size_t i = 0; i < tuple::length(v.list); ++i) items.push_back(value_at(type.item(i), tuple::item(v.list, i)));
    return value_of(std::move(items));
}

// Also one that the compiler has made.
std::optional<u32> find(const ModuleInfo& module, const std::string& name, std::size_t arity) {
    for (u32 i = 0; i < module.predicate_count; ++i)
        if (module.predicates[i].name == name && module.predicates[i].arity == arity) return i;
    return std::nullopt;
}

}  // namespace

Found collect(sim::Subdomain& subdomain, const check::Program& program, const std::string& suffix) {
    Found found{Facts(program.predicates.count()), std::vector<Bag>(program.predicates.count())};
    for (const PredicateId id : program.predicates.ids()) {
        const check::Predicate& p = program.predicates[id];
        const std::optional<u32> index = find(subdomain.module, p.name + suffix, p.arguments.size() - 1);
        if (!index || subdomain.module.predicates[*index].column == kNone16) continue;
        const PredicateInfo& info = subdomain.module.predicates[*index];
        for (sim::Catom c = 0; c < subdomain.ensemble.index_count(); ++c) {
            if (!subdomain.owned(c)) continue;
            tuple::each_fact(subdomain.module, subdomain.columns, subdomain.geometry(), *index, c, [&](const meld::Value* v) {
                Row row{value_of(static_cast<std::int64_t>(subdomain.ensemble.id(c)))};
                for (u32 i = 0; i < info.arity; ++i) row.push_back(value_at(tuple::type_of(subdomain.module, info.fields[i]), v[i]));
                if (p.linear())
                    found.linear[id.index()].insert(row);
                else
                    found.facts[id.index()].insert(row);
            });
        }
    }
    return found;
}

}  // namespace meld::reference
