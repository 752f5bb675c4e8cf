// Shared by the passes that add predicates and rules.
#pragma once

#include <string>

#include "compiler/check/program/program.h"
#include "runtime/base/assert.h"

namespace meld::desugar {

using check::PredicateId;
using check::RuleId;
using check::Term;
using check::VariableId;

inline Term variable_of(const check::Rule& rule, VariableId v) {
    Term t;
    t.op = check::Op::Variable;
    t.type = rule.variables[v].type;
    t.variable = v;
    t.span = rule.span;
    return t;
}

inline Term made_term(check::Op op, check::Type type, std::vector<Term> operands = {}) {
    Term t;
    t.op = op;
    t.type = std::move(type);
    t.operands = std::move(operands);
    return t;
}

// A rule that is about to be made, with an atom of fresh variables, one an argument of `predicate`.
struct MadeRule {
    check::Rule rule;
    check::Clause body;

    MadeRule(const check::Program& program, PredicateId predicate, std::string name) {
        const check::Predicate& p = program.predicates[predicate];
        MELD_EXPECT(!p.arguments.empty() && p.arguments[0].type == check::Type::Node, "{} has no catom", p.name);
        rule.name = std::move(name);
        rule.span = p.span;
        body.atom.predicate = predicate;
        body.atom.span = body.span = p.span;
        for (std::size_t i = 0; i < p.arguments.size(); ++i) {
            const VariableId v = rule.variables.add({i == 0 ? "A" : "X" + std::to_string(i), p.span, p.arguments[i].type});
            body.atom.arguments.push_back(variable_of(rule, v));
        }
        rule.site = body.atom.arguments[0].variable;
        rule.body = {body};
    }
    // Makes `predicate` of the arguments from `first` on, as many as it has.
    void head(const check::Program& program, PredicateId predicate, std::size_t first) {
        MELD_EXPECT(first + program.predicates[predicate].arguments.size() <= body.atom.arguments.size(), "rule {} has no arguments for {}",
                    rule.name, program.predicates[predicate].name);
        check::Head h{.kind = check::Head::Kind::Fact, .span = rule.span};
        h.atom.predicate = predicate;
        h.atom.span = rule.span;
        for (std::size_t i = 0; i < program.predicates[predicate].arguments.size(); ++i)
            h.atom.arguments.push_back(body.atom.arguments[first + i]);
        rule.heads.push_back(std::move(h));
    }
    void add_to(check::Program& program) {
        MELD_EXPECT(!rule.heads.empty() && rule.site.valid(), "rule {} is not finished", rule.name);
        rule.text = print(program, rule);
        program.rules.add(std::move(rule));
    }
};

}  // namespace meld::desugar
