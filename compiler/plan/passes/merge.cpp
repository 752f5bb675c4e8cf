// Pass: message merging. Localization makes an auxiliary for the remote part of each rule, `push` one for the best of a neighbour's rows.
// If two of them are derived by the same clauses, up to the names of variables, one serves both, and neighbours get it once instead of
// twice.
//     p(A) :- neighbor(A, B), neighbor(B, C), mark(C, V), V > 1.
//     q(A) :- neighbor(A, B), neighbor(B, C), mark(C, W), W > 1, calm(A).
// Assumes localized rules.
#include <map>

#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

// Gives every variable of a term or a clause its new name, if it has one.
template <class Part>
void rename(Part& part, const std::map<VariableId, VariableId>& names) {
    rewrite_variables(part, [&](VariableId& v) {
        if (const auto found = names.find(v); found != names.end()) v = found->second;
    });
}

// The rule as text with its variables numbered as they appear, the head first and without its name.
std::string shape(const Program& program, const Rule& rule) {
    MELD_EXPECT(!rule.linear && rule.heads.size() == 1, "rule {}", rule.name);
    Rule copy;
    std::map<VariableId, VariableId> names;
    const auto number = [&](VariableId v) {
        if (!names.contains(v)) names[v] = copy.variables.add({fmt::format("V{}", names.size()), {}, rule.variables[v].type});
    };
    for (const Term& t : rule.heads[0].atom.arguments) each_variable(t, number);
    for (const Clause& c : rule.body) each_variable(c, number);
    const Predicate& made = program.predicates[rule.heads[0].atom.predicate];
    std::string text = made.aggregate == Aggregate::None ? "" : fmt::format("{} {}: ", aggregate_name(program, made), made.aggregate_at);
    for (const Term& t : rule.heads[0].atom.arguments) {
        Term renamed = t;
        rename(renamed, names);
        text += print(program, copy, renamed) + " " + type_name(t.type) + ", ";
    }
    for (const Clause& c : rule.body) {
        Clause renamed = c;
        rename(renamed, names);
        text += "; " + print(program, copy, renamed);
    }
    return text;
}

void redirect(std::vector<Clause>& body, const std::map<PredicateId, PredicateId>& merged) {
    for (Clause& c : body) {
        if (const auto found = merged.find(c.atom.predicate); found != merged.end()) c.atom.predicate = found->second;
        redirect(c.inner, merged);
    }
}
void redirect(std::vector<Head>& heads, const std::map<PredicateId, PredicateId>& merged) {
    for (Head& h : heads) {
        redirect(h.body, merged);
        redirect(h.heads, merged);
        redirect(h.others, merged);
    }
}

}  // namespace

void merge_auxiliaries(check::Program& program) {
    // An auxiliary of an auxiliary is merged first, and then those that read it may be alike.
    for (bool again = true; again;) {
        std::map<std::string, PredicateId> first;
        std::map<PredicateId, PredicateId> merged;
        for (const Rule& rule : program.rules) {
            if (rule.linear) continue;
            const Predicate& p = program.predicates[rule.heads[0].atom.predicate];
            if (!p.auxiliary || (p.name.find(".far") == std::string::npos && p.name.find(".best") == std::string::npos)) continue;
            const auto [at, is_new] = first.emplace(shape(program, rule), rule.heads[0].atom.predicate);
            if (!is_new) merged[rule.heads[0].atom.predicate] = at->second;
        }
        again = !merged.empty();
        if (!again) return;
        Table<Rule> kept;
        for (Rule& rule : program.rules) {
            if (!rule.linear && merged.contains(rule.heads[0].atom.predicate)) continue;
            redirect(rule.body, merged);
            redirect(rule.heads, merged);
            kept.add(std::move(rule));
        }
        program.rules = std::move(kept);
    }
}

}  // namespace meld::plan
