#include "runtime/ask/why/existence.h"

#include <algorithm>
#include <string>

#include "compiler/check/program/values_read.h"

namespace meld::inspect {

using check::Clause;
using check::PredicateId;
using check::Rule;
using check::Term;
using check::VariableId;

namespace {

const check::Stratum* recursion_of(const check::Program& checked, PredicateId id) {
    for (const check::Stratum& s : checked.strata)
        if (s.recursive && s.contains(id)) return &s;
    return nullptr;
}

class OfExistence : public Facts {
  public:
    OfExistence(Facts& facts, const std::map<PredicateId, Source>& groups, const Program& program) : facts_(facts) {
        for (const auto& [p, source] : groups) sources_.emplace_back(program.source(p), source);
    }
    bool at(const Source& source, u64 catom, const Visit& visit) override {
        return facts_.at(of(source), catom, [&](const Fact& f) { return padded(source, f, visit); });
    }
    bool each(const Source& source, const Visit& visit) override {
        return facts_.each(of(source), [&](const Fact& f) { return padded(source, f, visit); });
    }
    bool back(const Source& source, u64 to, const Visit& visit) override { return facts_.back(source, to, visit); }
    bool exists(u64 catom) override { return facts_.exists(catom); }
    std::optional<Tombstone> loss(const Source& source, u64 catom, u64 group) override { return facts_.loss(source, catom, group); }

  private:
    const Source& of(const Source& source) const {
        for (const auto& [values, groups] : sources_)
            if (values == source) return groups;
        return source;
    }
    bool padded(const Source& source, Fact fact, const Visit& visit) const {
        std::vector<Value> arguments(fact.arguments, fact.arguments + of(source).arity);
        arguments.resize(source.arity);
        fact.arguments = arguments.data();
        return visit(fact);
    }
    Facts& facts_;
    std::vector<std::pair<Source, Source>> sources_;
};

}  // namespace

Existence::Existence(const Program& program) : program_(program) {
    find_groups();
    find_views();
    if (any()) find_recursions();
}

void Existence::find_groups() {
    const ModuleInfo& module = program_.module();
    for (const PredicateId p : program_.checked().predicates.ids()) {
        const check::Predicate& known = program_.checked().predicates[p];
        if (known.aggregate == check::Aggregate::None || program_.source(p).kind != Source::Kind::Stored) continue;
        for (u32 i = 0; i < module.predicate_count; ++i)
            if (module.predicates[i].name == known.name + "@some" && std::size_t{module.predicates[i].arity} + 1 == known.aggregate_at)
                groups_[p] = {.kind = Source::Kind::Stored, .predicate = i, .arity = module.predicates[i].arity};
    }
}

void Existence::find_views() {
    const check::Program& checked = program_.checked();
    views_.resize(checked.predicates.count());
    for (const Rule& rule : checked.rules) {
        if (rule.linear || rule.heads.size() != 1 || rule.heads[0].kind != check::Head::Kind::Fact) continue;
        const PredicateId head = rule.heads[0].atom.predicate;
        std::vector<const Rule*>& views = views_[head.index()];
        const auto sides = groups_.contains(head) ? check::sides_of_best(checked, rule) : std::nullopt;
        if (!sides) {
            views.push_back(&rule);
            continue;
        }
        for (const Rule& side : *sides) views.push_back(&sides_.emplace_back(side));
    }
}

bool Existence::asks(const Rule& rule, const std::vector<Clause>& body, const Bound& bound, bool open, const Clause& clause) const {
    if (clause.kind != Clause::Kind::Atom || !groups_.contains(clause.atom.predicate)) return false;
    const check::Program& checked = program_.checked();
    const std::vector<Term>& head = rule.heads[0].atom.arguments;
    const check::Stratum* const recursion = recursion_of(checked, rule.heads[0].atom.predicate);
    if (recursion == nullptr || !recursion->contains(clause.atom.predicate)) return false;
    const auto uses = [&](VariableId v) {
        std::size_t count = 0;
        for (const Clause& c : body) check::each_variable(c, [&](VariableId other) { count += other == v ? 1 : 0; });
        return count;
    };
    const check::Predicate& p = checked.predicates[clause.atom.predicate];
    for (std::size_t a = p.aggregate_at; a < clause.atom.arguments.size(); ++a) {
        const Term& term = clause.atom.arguments[a];
        if (term.op == check::Op::Anonymous) continue;
        if (!term.is_variable() || bound[term.variable.index()] || uses(term.variable) != 1) return false;
        bool in_head = false;
        for (const Term& t : head) check::each_variable(t, [&](VariableId v) { in_head = in_head || v == term.variable; });
        if (in_head && !open) return false;
    }
    return true;
}

void Existence::find_recursions() {
    const check::Program& checked = program_.checked();
    std::map<What, std::set<What>> reads;
    for (const check::Stratum& recursion : checked.strata) {
        if (!recursion.recursive) continue;
        for (const PredicateId p : recursion.predicates)
            for (const bool exists : {false, true}) {
                if (exists && !groups_.contains(p)) continue;
                std::set<What>& all = reads[{p, exists}];
                for (const Rule* rule : views(p))
                    for (const Clause& c : rule->body)
                        if (c.kind == Clause::Kind::Atom && recursion.contains(c.atom.predicate))
                            all.insert({c.atom.predicate, asks(*rule, rule->body, Bound(rule->variables.count()), exists, c)});
            }
    }
    std::map<What, std::set<What>> reached;
    for (const auto& [what, read] : reads) {
        std::vector<What> todo(read.begin(), read.end());
        while (!todo.empty()) {
            const What next = todo.back();
            todo.pop_back();
            if (reached[what].insert(next).second) todo.insert(todo.end(), reads[next].begin(), reads[next].end());
        }
    }
    for (const auto& [what, all] : reached)
        for (const What& other : all)
            if (const auto back = reached.find(other); back != reached.end() && back->second.contains(what))
                same_recursion_.insert({what, other});
}

std::unique_ptr<Facts> Existence::groups_of(Facts& facts) const { return std::make_unique<OfExistence>(facts, groups_, program_); }

}  // namespace meld::inspect
