#include "compiler/check/program/well_formed.h"

#include <algorithm>

#include "compiler/check/program/library.h"
#include "compiler/check/program/op_info.h"
#include "compiler/check/program/types.h"
#include "runtime/base/assert.h"

namespace meld::check {

namespace {

class WellFormed {
  public:
    explicit WellFormed(const Program& program) : program_(program) {}

    void run() {
        for (const Predicate& p : program_.predicates) predicate(p);
        for (const Constant& c : program_.constants) constant(c);
        for (const Function& f : program_.functions) function(f);
        for (const Rule& r : program_.rules) {
            MELD_CHECK(!r.refused && !r.name.empty(), "rule {} was refused without a message", r.name);
            MELD_CHECK(!r.arrives, "rule {} takes in what nobody sends", r.name);
            rule(r);
        }
        for (const Rule& question : program_.questions) body(question, question.body);
        strata();
    }

    void rule(const Rule& r) const {
        MELD_CHECK(r.site.valid() && r.site.index() < r.variables.count(), "rule {} runs nowhere", r.name);
        MELD_CHECK(r.linear || (r.heads.size() == 1 && r.heads[0].kind == Head::Kind::Fact), "view {} derives no fact", r.name);
        MELD_CHECK(r.linear || !(r.arrives || r.initial_fact || r.select != Select::None), "view {} is taken for a linear rule", r.name);
        body(r, r.body);
        each_head(r.heads, [&](const Head& h) { head(r, h); });
    }

  private:
    void predicate(const Predicate& p) const {
        MELD_CHECK(!p.name.empty() && !p.refused, "{} was refused without a message", p.name);
        MELD_CHECK(!p.arguments.empty() && p.arguments[0].type == Type::Node, "{} has no catom", p.name);
        for (const Argument& a : p.arguments) MELD_CHECK(!has_unknown(a.type), "{} has an argument of no type", p.name);
        MELD_CHECK(p.aggregate == Aggregate::None || (p.aggregate_at > 0 && p.aggregate_at < p.arguments.size()),
                   "{} aggregates argument {}", p.name, p.aggregate_at);
        aggregate(p.aggregate, p.fold, p.parameter, p.name);
        MELD_CHECK(!p.complete_link.valid() || program_.predicates[p.complete_link].route, "{} waits over no link", p.name);
        MELD_CHECK(!p.returns.valid() || program_.predicates[p.returns].linear(), "{} brings back facts that never leave", p.name);
        MELD_CHECK(!p.route || p.arguments.size() > 1, "the route {} leads nowhere", p.name);
    }

    // A function where it is one of the program's; a number where it keeps so many values.
    void aggregate(Aggregate which, FunctionId function, const Term& parameter, const std::string& where) const {
        MELD_CHECK((which == Aggregate::Custom) == function.valid(), "{}: an aggregate with a function of another", where);
        MELD_CHECK(!function.valid() || program_.functions[function].parameter_count == 2, "{}: a fold takes two values", where);
        if (info(which).has(AggregateInfo::kParameter)) MELD_CHECK(parameter.op != Op::Anonymous, "{}: how many values?", where);
        if (!info(which).has(AggregateInfo::kParameter) && which != Aggregate::Custom)
            MELD_CHECK(parameter.op == Op::Anonymous, "{}: an aggregate with the number of another", where);
    }

    void constant(const Constant& c) const {
        MELD_CHECK(c.argument || !has_unknown(c.type), "the constant {} has no type", c.name);
        if (!c.computed.valid()) return;
        MELD_CHECK(program_.functions[c.computed].parameter_count == 0, "the constant {} needs arguments", c.name);
        MELD_CHECK(program_.functions[c.computed].result == c.type, "the constant {} is of two types", c.name);
    }

    void function(const Function& f) const {
        MELD_CHECK(!f.refused, "the function {} was refused without a message", f.name);
        MELD_CHECK(f.parameter_count <= f.variables.count(), "{} has {} parameters", f.name, f.parameter_count);
        MELD_CHECK(f.external == (f.body.op == Op::Anonymous), "{} has a body, or two", f.name);
        MELD_CHECK(f.external || same(f.body.type, f.result), "{} gives {} and not {}", f.name, type_name(f.body.type),
                   type_name(f.result));
        term(f.variables, f.body, f.name);
    }

    void term(const Table<Variable>& variables, const Term& whole, const std::string& where) const {
        each_subterm(whole, [&](const Term& t) {
            if (const int count = info(t.op).operands; count != OpInfo::kMany)
                MELD_CHECK(t.operands.size() == static_cast<std::size_t>(count), "{}: operator {} of {}", where, static_cast<int>(t.op),
                           t.operands.size());
            if (t.is_variable() || t.op == Op::Let)
                MELD_CHECK(t.variable.valid() && t.variable.index() < variables.count(), "{}: an unknown variable", where);
            if (t.op == Op::Constant)
                MELD_CHECK(t.constant.valid() && t.constant.index() < program_.constants.count(), "{}: an unknown constant", where);
            if (t.op == Op::Call) {
                MELD_CHECK(t.function.valid() && t.function.index() < program_.functions.count(), "{}: an unknown function", where);
                MELD_CHECK(t.operands.size() == program_.functions[t.function].parameter_count, "{}: {} of {} values", where,
                           program_.functions[t.function].name, t.operands.size());
            }
            if (t.op == Op::Library)
                MELD_CHECK(library_function(t.text, t.operands.size()) != nullptr, "{}: no function {}", where, t.text);
            if (t.op == Op::Struct) MELD_CHECK(t.operands.size() == t.type.parts.size(), "{}: a struct of {}", where, t.operands.size());
            if (t.op >= Op::Equal && t.op <= Op::Or)
                MELD_CHECK(t.type == Type::Bool, "{}: a comparison of type {}", where, type_name(t.type));
        });
    }

    void atom(const Rule& r, const Atom& a) const {
        MELD_CHECK(a.predicate.valid() && a.predicate.index() < program_.predicates.count(), "rule {} names no predicate", r.name);
        const Predicate& p = program_.predicates[a.predicate];
        MELD_CHECK(a.arguments.size() == p.arguments.size(), "rule {}: {} with {} arguments", r.name, p.signature(), a.arguments.size());
        MELD_CHECK(a.arguments[0].is_variable(), "rule {} has {} at no variable", r.name, p.name);
        for (const Term& t : a.arguments) term(r.variables, t, r.name);
    }

    void body(const Rule& r, const std::vector<Clause>& clauses) const {
        for (const Clause& c : clauses) {
            if (c.kind == Clause::Kind::Atom || c.kind == Clause::Kind::Delta) atom(r, c.atom);
            term(r.variables, c.test, r.name);
            term(r.variables, c.parameter, r.name);
            const bool nests = c.kind == Clause::Kind::Not || c.kind == Clause::Kind::Aggregate;
            MELD_CHECK(nests == !c.inner.empty(), "rule {}: a clause with {} inside", r.name, c.inner.size());
            const bool binds = c.kind == Clause::Kind::Aggregate || c.kind == Clause::Kind::Element || c.kind == Clause::Kind::Delta;
            MELD_CHECK(!binds || c.variable.valid(), "rule {}: a clause that gives no variable its value", r.name);
            MELD_CHECK((c.kind == Clause::Kind::Aggregate) == (c.aggregate != Aggregate::None), "rule {}: an aggregate of nothing", r.name);
            if (c.kind == Clause::Kind::Test) MELD_CHECK(c.test.type == Type::Bool, "rule {} tests {}", r.name, type_name(c.test.type));
            aggregate(c.aggregate, c.fold, c.parameter, r.name);
            body(r, c.inner);
        }
    }

    void head(const Rule& r, const Head& h) const {
        if (h.kind == Head::Kind::Fact) atom(r, h.atom);
        MELD_CHECK(h.kind == Head::Kind::Fact || h.delay.op == Op::Anonymous, "rule {} delays what is no fact", r.name);
        MELD_CHECK((h.kind == Head::Kind::Aggregate) == !h.aggregates.empty(), "rule {}: a head of {} aggregates", r.name,
                   h.aggregates.size());
        MELD_CHECK((h.kind == Head::Kind::Set) == h.variable.valid(), "rule {}: a head that gives no variable its value", r.name);
        for (const HeadAggregate& a : h.aggregates) {
            MELD_CHECK(a.result.valid() && a.each.valid() == (a.aggregate != Aggregate::Count), "rule {}: an aggregate of nothing", r.name);
            aggregate(a.aggregate, a.function, a.parameter, r.name);
        }
        term(r.variables, h.term, r.name);
        body(r, h.body);
    }

    void strata() const {
        constexpr std::size_t kNowhere = static_cast<std::size_t>(-1);
        std::vector<std::size_t> stratum(program_.predicates.count(), kNowhere);
        for (std::size_t i = 0; i < program_.strata.size(); ++i)
            for (const PredicateId p : program_.strata[i].predicates) {
                MELD_CHECK(stratum[p.index()] == kNowhere, "{} is in two strata", program_.predicates[p].name);
                stratum[p.index()] = i;
            }
        MELD_CHECK(std::find(stratum.begin(), stratum.end(), kNowhere) == stratum.end(), "a predicate is in no stratum");
        for (const Rule& r : program_.rules) {
            if (r.linear) continue;
            const std::size_t own = stratum[r.heads[0].atom.predicate.index()];
            each_atom(r.body, [&](const Atom& a, bool negated) {
                const std::size_t read = stratum[a.predicate.index()];
                const bool of_earlier_rounds = read == own && program_.strata[own].rounds;
                MELD_CHECK(read < own || (read == own && !negated) || of_earlier_rounds, "rule {} reads {}, which is evaluated later",
                           r.name, program_.predicates[a.predicate].name);
            });
        }
    }

    const Program& program_;
};

}  // namespace

void expect_well_formed(const Program& program) { WellFormed(program).run(); }
void expect_well_formed(const Program& program, const Rule& rule) { WellFormed(program).rule(rule); }

}  // namespace meld::check
