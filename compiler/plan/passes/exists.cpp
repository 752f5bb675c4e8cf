// Pass: existence. A rule of a recursion may ask whether a group of min or max has a value at all, or one beyond a bound:
//     p(A) :- m(A, _).     m(B, 4.0) :- neighbor(A, B), p(A).     m(A, 3.75).
// The answer stays true while the value improves, but a better value may depend on p itself; p would then lose its support through what it
// led to, and never quiesce. So the rule reads a view of the groups instead, which the rules of m derive beside the values:
//     p(A) :- m@some(A).   m@some(B) :- neighbor(A, B), p(A).         m@some(A).
// Computing max(X, Y) from a value X of a max tests existence in the same way, so it becomes two rules, for X and for Y. Assumes that given
// facts are separate.
#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>

#include "compiler/check/program/values_read.h"
#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

constexpr std::size_t kMaxRules = 64;

class Existence {
  public:
    explicit Existence(Program& program) : program_(program) {}

    void run() {
        find_strongly_connected();
        for (std::size_t i = 0, end = program_.rules.count(); i < end; ++i) split(RuleId(i));
        for (std::size_t i = 0, end = program_.rules.count(); i < end; ++i) {
            if (!asks(program_.rules[RuleId(i)])) continue;
            // All or nothing: views of groups that depend on values would appear and disappear like these.
            Program as_it_was = program_;
            const auto stratum = stratum_;
            const auto made = made_;
            if (answer(RuleId(i))) continue;
            program_ = std::move(as_it_was);
            stratum_ = stratum;
            made_ = made;
        }
    }

  private:
    void find_strongly_connected() {
        plan::find_strongly_connected(program_);
        for (std::size_t i = 0; i < program_.strata.size(); ++i) {
            const check::Stratum& c = program_.strata[i];
            if (!c.recursive || c.tree) continue;
            for (const PredicateId p : c.predicates) stratum_[p] = i + 1;
        }
    }

    // Whether the atom is of the stratum that the rule derives.
    bool recursive(const Rule& rule, const Clause& c) const {
        if (rule.linear || c.kind != Clause::Kind::Atom) return false;
        const auto own = stratum_.find(rule.heads[0].atom.predicate), other = stratum_.find(c.atom.predicate);
        return own != stratum_.end() && other != stratum_.end() && own->second == other->second;
    }
    ValueRead read_by(const Rule& rule, const Clause& c) const {
        return recursive(rule, c) ? value_read(program_, rule, c.atom) : ValueRead{};
    }
    bool asks(const Rule& rule) const {
        return std::any_of(rule.body.begin(), rule.body.end(),
                           [&](const Clause& c) { return read_by(rule, c).kind == ValueRead::Kind::Exists; });
    }

    // m(B, max(X, Y)) :- m(A, X), q(B, Y).
    void split(RuleId id) {
        const Rule& rule = program_.rules[id];
        if (rule.linear || std::none_of(rule.body.begin(), rule.body.end(),
                                        [&](const Clause& c) { return read_by(rule, c).kind == ValueRead::Kind::Used; }))
            return;
        std::optional<std::array<Rule, 2>> both = sides_of_best(program_, rule);
        if (!both || (!asks((*both)[0]) && !asks((*both)[1]))) return;
        auto& sides = *both;
        sides[1].name += ".or";
        program_.rules[id] = std::move(sides[0]);
        program_.rules.add(std::move(sides[1]));
    }

    // Lets the rule read views of the groups, and makes these views. False: they would depend on values.
    bool answer(RuleId first) {
        std::vector<RuleId> todo{first};
        for (std::size_t at = 0; at < todo.size(); ++at) {
            // Different bounds would combine to many views: then fronts (fronts.cpp) are cheaper.
            if (todo.size() > kMaxRules) return false;
            for (std::size_t i = 0; i < program_.rules[todo[at]].body.size(); ++i) {
                const ValueRead read = read_by(program_.rules[todo[at]], program_.rules[todo[at]].body[i]);
                if (read.kind == ValueRead::Kind::Used && at > 0) return false;
                if (read.kind != ValueRead::Kind::Exists) continue;
                const PredicateId groups = groups_of(todo[at], i, read, todo);
                Rule& rule = program_.rules[todo[at]];
                rule.body[i].atom.predicate = groups;
                rule.body[i].atom.arguments.resize(program_.predicates[groups].arguments.size());
                for (auto t = read.tests.rbegin(); t != read.tests.rend(); ++t)
                    rule.body.erase(rule.body.begin() + static_cast<std::ptrdiff_t>(*t));
                i = static_cast<std::size_t>(-1);
            }
        }
        return true;
    }

    // The groups of m whose value passes this rule's tests, with one rule for each of m's, which are added to `rules`.
    PredicateId groups_of(RuleId asking, std::size_t clause, const ValueRead& read, std::vector<RuleId>& rules) {
        const PredicateId m = program_.rules[asking].body[clause].atom.predicate;
        std::vector<Clause> tests;
        std::string written;
        std::set<std::string> distinct;
        for (const std::size_t t : read.tests) {
            tests.push_back(program_.rules[asking].body[t]);
            Rule named;
            named.variables.add({"Value", {}, {}});
            Term test = tests.back().test;
            rewrite_variables(test, [&](VariableId& v) { v = v.valid() ? VariableId(0) : v; });
            // A rule that asks what the rule it hands on to asks too would otherwise ask once more at every turn.
            if (!distinct.insert(print(program_, named, test)).second) tests.pop_back();
        }
        for (const std::string& test : distinct) written += test + ";";
        const auto [known, fresh] = made_.try_emplace({m, written});
        if (!fresh) return known->second;
        const Predicate of = program_.predicates[m];
        MELD_EXPECT(keeps_best(of.aggregate), "{} has no value that improves", of.name);
        Predicate groups;
        groups.name = fmt::format("{}@some{}", of.name, written.empty() ? "" : std::to_string(made_.size()));
        groups.span = of.span;
        groups.auxiliary = true;
        groups.arguments.assign(of.arguments.begin(), of.arguments.begin() + static_cast<std::ptrdiff_t>(of.aggregate_at));
        const PredicateId id = known->second = program_.predicates.add(groups);
        stratum_[id] = stratum_[m];
        for (std::size_t i = 0, end = program_.rules.count(); i < end; ++i) {
            const Rule& rule = program_.rules[RuleId(i)];
            if (rule.linear || rule.heads[0].atom.predicate != m) continue;
            Rule copy = rule;
            copy.name += groups.name.substr(of.name.size());
            Atom& head = copy.heads[0].atom;
            for (Clause test : tests) {
                put(test.test, head.arguments[of.aggregate_at]);
                copy.body.push_back(std::move(test));
            }
            head.predicate = id;
            head.arguments.resize(of.aggregate_at);
            drop_unread(copy);
            rules.push_back(program_.rules.add(std::move(copy)));
        }
        return id;
    }
    static void put(Term& test, const Term& value) {
        if (test.is_variable()) {
            test = value;
            return;
        }
        for (Term& operand : test.operands) put(operand, value);
    }
    // Y = X + 1, where nothing reads Y any more. The rule of the values still finds where X + 1 has no value.
    static void drop_unread(Rule& rule) {
        const auto unread = [&](const Clause& c) {
            if (c.kind != Clause::Kind::Test || c.test.op != Op::Equal) return false;
            return std::any_of(c.test.operands.begin(), c.test.operands.end(),
                               [&](const Term& side) { return side.is_variable() && uses(rule, side.variable) == 1; });
        };
        for (auto found = rule.body.begin(); found != rule.body.end();) {
            found = std::find_if(rule.body.begin(), rule.body.end(), unread);
            if (found == rule.body.end()) return;
            rule.body.erase(found);
            found = rule.body.begin();
        }
    }

    Program& program_;
    std::map<PredicateId, std::size_t> stratum_;  // The recursive one, counted from 1.
    std::map<std::pair<PredicateId, std::string>, PredicateId> made_;
};

}  // namespace

void ask_for_existence(Program& program) { Existence(program).run(); }

}  // namespace meld::plan
