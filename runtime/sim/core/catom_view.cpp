// A CodeModule's view of its program and its catom.
#include <fmt/format.h>

#include "runtime/base/assert.h"
#include "runtime/base/did_you_mean.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/sim/core/extension.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {
namespace {

bool takes_facts(const PredicateInfo& p) { return !p.auxiliary && p.base != kNone16 && p.column != kNone16; }
bool is_action(const PredicateInfo& p) { return !p.auxiliary && p.kind == PredicateKind::Action; }
bool is_linear(const PredicateInfo& p) { return takes_facts(p) && p.kind == PredicateKind::Linear; }
bool has_facts(const PredicateInfo& p) { return !p.auxiliary && p.column != kNone16; }

Result<Predicate> look_up(const ModuleInfo& module, std::string_view name, std::size_t arguments, bool (*fits)(const PredicateInfo&),
                          std::string_view purpose) {
    const std::optional<u32> found = tuple::find_predicate(module, name, arguments);
    if (found && fits(module.predicates[*found])) return Predicate(*found);
    std::vector<std::string_view> known;
    for (u32 i = 0; i < module.predicate_count; ++i)
        if (fits(module.predicates[i])) known.emplace_back(module.predicates[i].name);
    return fail(fmt::format("the program has no predicate {} with {} argument{} after the catom that a module can {}", name, arguments,
                            arguments == 1 ? "" : "s", purpose),
                known.empty() ? "Declare it in the program" : did_you_mean(name, known));
}

std::vector<Value> values_of(const ModuleInfo& module, const PredicateInfo& p, const std::vector<Argument>& arguments,
                             tuple::Arena& arena) {
    MELD_CHECK(arguments.size() == p.arity, "a module gives {} arguments to {}, which has {}", arguments.size(), p.name, p.arity);
    std::vector<Value> values;
    for (u32 i = 0; i < p.arity; ++i) values.push_back(to_value(tuple::type_of(module, p.fields[i]), arguments[i], arena));
    return values;
}

}  // namespace

Result<Predicate> Names::sensed(std::string_view name, std::size_t arguments) const {
    return look_up(module_, name, arguments, takes_facts, "sense");
}

Result<Predicate> Names::stored(std::string_view name, std::size_t arguments) const {
    return look_up(module_, name, arguments, has_facts, "read");
}

Result<Predicate> Names::action(std::string_view name, std::size_t arguments) const {
    return look_up(module_, name, arguments, is_action, "ask for as an action");
}

Result<Predicate> Names::linear(std::string_view name, std::size_t arguments) const {
    return look_up(module_, name, arguments, is_linear, "send as a linear fact");
}

std::uint64_t CatomView::id() const { return subdomain_.ensemble.id(catom_); }
world::Vec3 CatomView::position() const { return subdomain_.ensemble.position(catom_); }
std::int64_t CatomView::tick() const { return subdomain_.tick(); }

void CatomView::sense(Predicate predicate, const std::vector<Argument>& arguments) {
    const PredicateInfo& p = subdomain_.module.predicates[predicate.number()];
    tuple::Arena arena;
    subdomain_.give(p.base, catom_, values_of(subdomain_.module, p, arguments, arena).data());
}

void CatomView::unsense(Predicate predicate, const std::vector<Argument>& arguments) {
    const PredicateInfo& p = subdomain_.module.predicates[predicate.number()];
    tuple::Arena arena;
    subdomain_.take(p.base, catom_, values_of(subdomain_.module, p, arguments, arena).data());
}

std::vector<std::vector<Argument>> CatomView::facts(Predicate predicate) const {
    const ModuleInfo& module = subdomain_.module;
    const PredicateInfo& p = module.predicates[predicate.number()];
    std::vector<std::vector<Argument>> all;
    tuple::each_fact(module, subdomain_.columns, subdomain_.ensemble.geometry(), predicate.number(), catom_, [&](const Value* values) {
        std::vector<Argument>& fact = all.emplace_back();
        for (u32 i = 0; i < p.arity; ++i) fact.push_back(to_argument(tuple::type_of(module, p.fields[i]), values[i]));
    });
    return all;
}

std::vector<CatomId> CatomView::neighbors() const {
    std::vector<CatomId> ids;
    subdomain_.each_neighbour(catom_, [&](Catom other) { ids.push_back({subdomain_.ensemble.id(other)}); });
    return ids;
}

void CatomView::act(Predicate action, const std::vector<Argument>& arguments) {
    const PredicateInfo& p = subdomain_.module.predicates[action.number()];
    MELD_CHECK(is_action(p), "a module acts with {}, which is not an action", p.name);
    tuple::Arena arena;
    const std::vector<Value> values = values_of(subdomain_.module, p, arguments, arena);
    subdomain_.facts_.evaluator.requests().act(catom_, static_cast<u16>(action.number()), values.data());
}

bool CatomView::send(CatomId to, Predicate linear, const std::vector<Argument>& arguments) {
    const PredicateInfo& p = subdomain_.module.predicates[linear.number()];
    MELD_CHECK(is_linear(p), "a module sends {}, which is not linear", p.name);
    std::optional<Catom> neighbour;
    subdomain_.each_neighbour(catom_, [&](Catom other) {
        if (subdomain_.ensemble.id(other) == to.number) neighbour = other;
    });
    if (!neighbour) return false;
    tuple::Arena arena;
    const std::vector<Value> values = values_of(subdomain_.module, p, arguments, arena);
    subdomain_.facts_.evaluator.requests().send(*neighbour, p.base, id(), values.data());
    return true;
}

}  // namespace meld::sim
