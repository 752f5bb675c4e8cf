#include "runtime/results/facts/sorted_facts.h"

#include <algorithm>

#include "runtime/engine/tuple/facts.h"

namespace meld::record {

std::vector<std::pair<u64, sim::Catom>> catoms_by_id(const sim::Subdomain& subdomain) {
    std::vector<std::pair<u64, sim::Catom>> order;
    order.reserve(subdomain.ensemble.owned_count());
    for (sim::Catom c = 0; c < subdomain.ensemble.index_count(); ++c)
        if (subdomain.owned(c)) order.emplace_back(subdomain.ensemble.id(c), c);
    std::sort(order.begin(), order.end());
    return order;
}

std::vector<std::vector<Value>> sorted_facts(const sim::Subdomain& subdomain, u32 predicate, sim::Catom catom) {
    const PredicateInfo& p = subdomain.module.predicates[predicate];
    std::vector<std::vector<Value>> facts;
    tuple::each_fact(subdomain.module, subdomain.columns, subdomain.geometry(), predicate, catom,
                     [&](const Value* v) { facts.emplace_back(v, v + p.arity); });
    std::sort(facts.begin(), facts.end(),
              [&](const auto& a, const auto& b) { return tuple::compare_arguments(subdomain.module, p, a.data(), b.data()) < 0; });
    return facts;
}

}  // namespace meld::record
