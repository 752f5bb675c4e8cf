// Pass: facts in the text. A program that contains its world gives thousands of facts, each about one catom; a rule for each of them would
// be compiled, and tried at every catom. Many facts of one predicate become one rule over a table that is searched by catom, wherever they
// are, as long as no other rule of the predicate comes between them. Facts of several predicates may stand in turn.
//     edge(@0, @1, 3).  edge(@0, @2, 5).  ...        edge(A, X1, X2) :- edge'facts(A, X1, X2).
// Linear ones, which a catom is given once, become one comprehension. Assumes folded constants.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "compiler/desugar/made.h"
#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

constexpr std::size_t kMany = 16;  // With fewer, separate rules are as good, and `narrow` and messages can see through them.

bool is_constant_term(const Term& t) {
    switch (t.op) {
        case Op::Int:
        case Op::Bool:
        case Op::Node:
            return true;
        case Op::Float:
            return std::isfinite(t.real);
        case Op::ToFloat:
            return t.operands[0].op == Op::Int;
        case Op::String:
            return true;
        case Op::List:
        case Op::Struct:
        case Op::Tuple:
            // A set is sorted when it is made.
            return t.type.kind != Type::Kind::Set && std::all_of(t.operands.begin(), t.operands.end(), is_constant_term);
        default:
            return false;
    }
}

// The catom that a rule names, if the rule gives one fact about it and nothing else.
std::optional<std::int64_t> catom_of(const Rule& rule) {
    if (rule.heads.size() != 1 || rule.body.size() != 1 || rule.select != Select::None || rule.arrives ||
        (rule.linear && !rule.initial_fact))
        return {};
    const Head& head = rule.heads[0];
    const Clause& c = rule.body[0];
    if (head.kind != Head::Kind::Fact || head.delay.op != Op::Anonymous || c.kind != Clause::Kind::Test || c.test.op != Op::Equal)
        return {};
    const std::vector<Term>& arguments = head.atom.arguments;
    const bool here = arguments[0].is_variable() && arguments[0].variable == rule.site && c.test.operands[0].is_variable() &&
                      c.test.operands[0].variable == rule.site;
    if (!here || c.test.operands[1].op != Op::Node || !std::all_of(arguments.begin() + 1, arguments.end(), is_constant_term)) return {};
    return c.test.operands[1].integer;
}

// One rule for the facts that `rules` say, which are alike.
Rule gathered(Program& program, const std::vector<const Rule*>& rules) {
    MELD_EXPECT(rules.size() >= kMany, "{} facts are too few for a table", rules.size());
    const Rule& first = *rules[0];
    const PredicateId to = first.heads[0].atom.predicate;
    Predicate table;
    table.name = program.predicates[to].name + "'facts";
    table.span = program.predicates[to].span;
    table.arguments = program.predicates[to].arguments;
    table.kind = PredicateKind::Sensed;
    table.auxiliary = true;
    table.world = WorldSource::Facts;
    for (const Rule* r : rules)
        table.facts.push_back({*catom_of(*r), {r->heads[0].atom.arguments.begin() + 1, r->heads[0].atom.arguments.end()}, r->line});
    std::stable_sort(table.facts.begin(), table.facts.end(), [](const Fact& a, const Fact& b) {
        return static_cast<std::uint64_t>(a.catom) < static_cast<std::uint64_t>(b.catom);
    });
    const PredicateId from = program.predicates.add(std::move(table));

    desugar::MadeRule made(program, from, first.name);
    made.head(program, to, 0);
    made.rule.span = first.span;
    made.rule.file = first.file;
    made.rule.line = first.line;
    made.rule.derives = first.derives;
    made.rule.text = fmt::format("{} and {} more facts up to line {}", first.text, rules.size() - 1, rules.back()->line);
    if (first.linear) {
        made.rule.linear = made.rule.initial_fact = true;
        made.rule.heads = {{.kind = Head::Kind::Comprehension,
                            .body = std::move(made.rule.body),
                            .heads = std::move(made.rule.heads),
                            .span = first.span}};
        made.rule.body.clear();
    }
    return std::move(made.rule);
}

}  // namespace

void gather_facts(Program& program) {
    // Similar facts without another rule of their predicate between them, so that each predicate gets its facts in the order of the text.
    std::vector<std::vector<const Rule*>> runs;
    std::vector<std::optional<std::size_t>> run_of(program.rules.count());
    std::map<std::pair<PredicateId, bool>, std::size_t> open;
    for (const RuleId id : program.rules.ids()) {
        const Rule& rule = program.rules[id];
        if (!catom_of(rule)) {
            each_head(rule.heads, [&](const Head& h) {
                if (h.kind != Head::Kind::Fact) return;
                for (const bool linear : {false, true}) open.erase({h.atom.predicate, linear});
            });
            continue;
        }
        const auto [run, is_new] = open.emplace(std::pair(rule.heads[0].atom.predicate, rule.linear), runs.size());
        if (is_new) runs.emplace_back();
        runs[run->second].push_back(&rule);
        run_of[id.index()] = run->second;
    }
    Table<Rule> kept;
    for (const RuleId id : program.rules.ids()) {
        static const std::vector<const Rule*> alone;
        const std::vector<const Rule*>& run = run_of[id.index()] ? runs[*run_of[id.index()]] : alone;
        if (run.size() < kMany)
            kept.add(program.rules[id]);
        else if (run[0] == &program.rules[id])
            kept.add(gathered(program, run));
    }
    program.rules = std::move(kept);
}

}  // namespace meld::plan
