// A catom that a rule names, @1, is one like any other: each rule is written with the literal and with a variable V = @1. Both must have
// the facts that the reference evaluator has, and the same.
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <vector>

#include "tests/reference/trials/run.h"

namespace meld::reference {
namespace {

// P(node, int) is given at random; Q(node, int) is derived. Linear rules consume T(node, int) and W(node), and make U(node, int).
struct Pair {
    std::string name, literal, variable;
};

constexpr const char* kDeclarations = R"(
type p(node, int).
type route way(node, node).
way(A, B) :- neighbor(A, B), p(A, _).
const first = @1.
)";

const std::vector<Pair> kViews = {
    {"BodyBehindALink", "Q(A, X) :- neighbor(A, @1), p(@1, X).", "Q(A, X) :- V = @1, neighbor(A, V), p(V, X)."},
    {"BodyBeforeALink", "Q(A, X) :- p(@1, X), neighbor(@1, A).", "Q(A, X) :- V = @1, p(V, X), neighbor(V, A)."},
    {"Site", "Q(@1, X) :- p(@1, X).", "Q(V, X) :- V = @1, p(V, X)."},
    {"Head", "Q(@1, X) :- neighbor(A, @1), p(A, X).", "Q(V, X) :- V = @1, neighbor(A, V), p(A, X)."},
    {"HeadOfLinkThere", "Q(@1, X) :- neighbor(@1, A), p(A, X).", "Q(V, X) :- V = @1, neighbor(V, A), p(A, X)."},
    {"TwoHeads", "Q(A, X), Q(@1, 9) :- neighbor(A, @1), p(@1, X).", "Q(A, X), Q(V, 9) :- V = @1, neighbor(A, V), p(V, X)."},
    {"Axiom", "Q(@1, 4). Q(A, X) :- neighbor(A, @1), Q(@1, X).", "Q(V, 4) :- V = @1. Q(A, X) :- V = @1, neighbor(A, V), Q(V, X)."},
    {"Not", "Q(@0, 1) :- not p(@0, _).", "Q(V, 1) :- V = @0, not p(V, _)."},
    {"NotElsewhere", "Q(A, 1) :- neighbor(A, @1), not p(@1, _).", "Q(A, 1) :- V = @1, neighbor(A, V), not p(V, _)."},
    {"NotWithLink", "Q(A, 1) :- p(A, _), not (neighbor(A, @1), p(@1, _)).", "Q(A, 1) :- V = @1, p(A, _), not (neighbor(A, V), p(V, _))."},
    {"NotInNot", "Q(A, 1) :- p(A, _), not (neighbor(A, B), not (neighbor(B, @1), p(@1, _))).",
     "Q(A, 1) :- V = @1, p(A, _), not (neighbor(A, B), not (neighbor(B, V), p(V, _)))."},
    {"Forall", "Q(A, 1) :- p(A, _), forall neighbor(A, @1) [p(@1, _)].", "Q(A, 1) :- V = @1, p(A, _), forall neighbor(A, V) [p(V, _)]."},
    {"Count", "Q(@0, C) :- C = count : { p(@0, _) }.", "Q(V, C) :- V = @0, C = count : { p(V, _) }."},
    {"CountElsewhere", "Q(A, C) :- neighbor(A, @1), C = count : { p(@1, _) }.",
     "Q(A, C) :- V = @1, neighbor(A, V), C = count : { p(V, _) }."},
    {"SumWithLink", "Q(A, S) :- p(A, _), S = sum X : { neighbor(A, @1), p(@1, X) }.",
     "Q(A, S) :- V = @1, p(A, _), S = sum X : { neighbor(A, V), p(V, X) }."},
    {"Proved", "Q(A, 3) :- neighbor(A, @1), proved(@1, p) > 1.", "Q(A, 3) :- V = @1, neighbor(A, V), proved(V, p) > 1."},
    {"Stable", "Q(A, X) :- neighbor(A, @1), stable(p(@1, X), 2).", "Q(A, X) :- V = @1, neighbor(A, V), stable(p(V, X), 2)."},
    {"OverTwoLinks", "Q(A, X) :- neighbor(A, B), neighbor(B, @1), p(@1, X).",
     "Q(A, X) :- V = @1, neighbor(A, B), neighbor(B, V), p(V, X)."},
    {"InTheMiddle", "Q(A, X) :- neighbor(A, @1), neighbor(@1, B), p(B, X).", "Q(A, X) :- V = @1, neighbor(A, V), neighbor(V, B), p(B, X)."},
    {"FarEndsMeet", "Q(B, X) :- neighbor(A, @1), neighbor(B, @1), p(A, X).", "Q(B, X) :- V = @1, neighbor(A, V), neighbor(B, V), p(A, X)."},
    {"FarEndsMeetInNot", "Q(A, 1) :- p(A, _), not (neighbor(A, @1), neighbor(B, @1), p(B, _)).",
     "Q(A, 1) :- V = @1, p(A, _), not (neighbor(A, V), neighbor(B, V), p(B, _))."},
    {"OwnRoute", "Q(A, X) :- way(A, @1), p(@1, X).", "Q(A, X) :- V = @1, way(A, V), p(V, X)."},
    {"OwnRouteBack", "Q(@1, X) :- way(A, @1), p(A, X).", "Q(V, X) :- V = @1, way(A, V), p(A, X)."},
    {"TwoCatoms", "Q(@0, X) :- p(@0, X), not neighbor(@0, @1).", "Q(U, X) :- U = @0, V = @1, p(U, X), not neighbor(U, V)."},
    {"Constant", "Q(A, X) :- neighbor(A, first), p(first, X).", "Q(A, X) :- V = first, neighbor(A, V), p(V, X)."},
    {"ConstantAndNumber", "Q(A, X) :- neighbor(A, first), p(@1, X).", "Q(A, X) :- V = @1, neighbor(A, V), p(V, X)."},
    {"OlderSign", "Q(A, X) :- neighbor(A, #1), p(@1, X).", "Q(A, X) :- V = @1, neighbor(A, V), p(V, X)."},
    {"BesideItsVariable", "Q(A, X) :- V = @1, neighbor(A, V), p(@1, X).", "Q(A, X) :- V = @1, neighbor(A, V), p(V, X)."},
    {"VariableOfAFact", "Q(A, X) :- neighbor(A, B), B = @1, p(@1, X).", "Q(A, X) :- neighbor(A, B), B = @1, p(B, X)."},
    {"SiteOfAnotherName", "Q(A, X) :- A = @1, p(@1, X).", "Q(A, X) :- A = @1, p(A, X)."},
    {"Element", "Q(A, X) :- neighbor(A, @1), p(@1, X), X in [1, 2, 3].", "Q(A, X) :- V = @1, neighbor(A, V), p(V, X), X in [1, 2, 3]."},
    {"HeadComprehension", "{ X | neighbor(A, @1), p(@1, X) | Q(A, X) } :- p(A, _).",
     "{ X | neighbor(A, V), p(V, X) | Q(A, X) } :- V = @1, p(A, _)."},
    {"Delayed", "Q(A, X)@+2 :- neighbor(A, @1), p(@1, X).", "Q(A, X)@+2 :- V = @1, neighbor(A, V), p(V, X)."},
};

const std::vector<Pair> kLinear = {
    {"Site", "T(@1, X) -o U(@1, X).", "V = @1, T(V, X) -o U(V, X)."},
    {"SiteAndHead", "T(A, X), A = @1 -o U(@1, X).", "T(A, X), A = @1 -o U(A, X)."},
    {"BodyBehindALink", "T(A, X), neighbor(A, @1), p(@1, Y) -o U(A, X + Y).", "V = @1, T(A, X), neighbor(A, V), p(V, Y) -o U(A, X + Y)."},
    {"HeadBehindALink", "T(A, X), neighbor(A, @1) -o U(@1, X).", "V = @1, T(A, X), neighbor(A, V) -o U(V, X)."},
    {"HeadBeforeALink", "T(A, X), neighbor(@1, A) -o U(@1, X).", "V = @1, T(A, X), neighbor(V, A) -o U(V, X)."},
    {"MessageOverTwoLinks", "T(A, X), neighbor(A, B), neighbor(B, @1) -o U(@1, X).",
     "V = @1, T(A, X), neighbor(A, B), neighbor(B, V) -o U(V, X)."},
    {"MessageFromThere", "T(@1, X), neighbor(@1, B), neighbor(B, C) -o U(C, X).",
     "V = @1, T(V, X), neighbor(V, B), neighbor(B, C) -o U(C, X)."},
    {"NotLinear", "T(@1, X), not W(@1) -o U(@1, X). W(@2).", "V = @1, T(V, X), not W(V) -o U(V, X). W(@2)."},
    {"NotElsewhere", "T(A, X), neighbor(A, @1), not p(@1, _) -o U(A, X).", "V = @1, T(A, X), neighbor(A, V), not p(V, _) -o U(A, X)."},
    {"CountElsewhere", "T(A, X), neighbor(A, @1), C = count : { p(@1, _) } -o U(A, X + C).",
     "V = @1, T(A, X), neighbor(A, V), C = count : { p(V, _) } -o U(A, X + C)."},
    {"Comprehension", "T(@1, X) -o { B | neighbor(@1, B) | U(B, X) }.", "V = @1, T(V, X) -o { B | neighbor(V, B) | U(B, X) }."},
    {"ComprehensionReads", "T(A, X) -o { Y | neighbor(A, @1), p(@1, Y) | U(A, X + Y) }.",
     "V = @1, T(A, X) -o { Y | neighbor(A, V), p(V, Y) | U(A, X + Y) }."},
    {"ComprehensionSends", "T(A, X) -o { | neighbor(A, @1) | U(@1, X) }.", "V = @1, T(A, X) -o { | neighbor(A, V) | U(V, X) }."},
    {"RuleAggregate", "T(A, X) -o [count => N | Y | neighbor(A, @1), p(@1, Y) | | U(A, X + N)].",
     "V = @1, T(A, X) -o [count => N | Y | neighbor(A, V), p(V, Y) | | U(A, X + N)]."},
    {"Exists", "T(@1, X) -o exists K. (U(@1, X), U(@1, K)).", "V = @1, T(V, X) -o exists K. (U(V, X), U(V, K))."},
    {"ExistsThere", "T(A, X), neighbor(A, @1) -o exists K. (U(@1, X), U(@1, K)).",
     "V = @1, T(A, X), neighbor(A, V) -o exists K. (U(V, X), U(V, K))."},
    {"If", "T(A, X), neighbor(A, @1) -o (if X > 1 then U(@1, X) otherwise U(A, X) end).",
     "V = @1, T(A, X), neighbor(A, V) -o (if X > 1 then U(V, X) otherwise U(A, X) end)."},
    {"Delayed", "T(A, X), neighbor(A, @1) -o U(@1, X)@+2.", "V = @1, T(A, X), neighbor(A, V) -o U(V, X)@+2."},
    {"Selector", "[desc => X | T(@1, X)] -o U(@1, X).", "[desc => X | V = @1, T(V, X)] -o U(V, X)."},
    {"Axiom", "T(@1, 7). T(A, X), neighbor(A, @1) -o U(@1, X).", "T(V, 7) :- V = @1. V = @1, T(A, X), neighbor(A, V) -o U(V, X)."},
    {"Action", "T(@1, X) -o setColor(@1, X, 0, 0), U(@1, X).", "V = @1, T(V, X) -o setColor(V, X, 0, 0), U(V, X)."},
    {"Constant", "T(A, X), neighbor(A, first) -o U(@1, X).", "V = @1, T(A, X), neighbor(A, V) -o U(V, X)."},
};

// The rules of a pair, with predicates of its own.
std::string numbered(const std::string& rules, std::size_t number) {
    static const std::regex mark(R"(\b([QTUW])\()");
    std::string text;
    std::size_t end = 0;
    for (std::sregex_iterator it(rules.begin(), rules.end(), mark); it != std::sregex_iterator(); ++it) {
        text += rules.substr(end, static_cast<std::size_t>(it->position()) - end);
        text += static_cast<char>(std::tolower(it->str(1)[0])) + std::to_string(number) + "(";
        end = static_cast<std::size_t>(it->position() + it->length());
    }
    return text + rules.substr(end);
}

std::string one_program(const std::vector<Pair>& pairs, std::string Pair::* form, const std::vector<std::size_t>& which) {
    std::string text = kDeclarations;
    for (const std::size_t i : which) {
        const auto uses = [&](const char* predicate) { return pairs[i].literal.find(predicate) != std::string::npos; };
        std::string rules;
        if (uses("Q(")) rules += "type Q(node, int).\n";
        if (uses("U(")) rules += "type linear T(node, int).\ntype U(node, int).\nT(A, 1). T(A, 2).\n";
        if (uses("W(")) rules += "type linear W(node).\n";
        text += numbered(rules + pairs[i].*form + "\n", i);
    }
    return text;
}

retraction::Given given() { return {.predicate = "p", .arguments = {{0, 4}}, .per_mille = 400}; }

void expect_alike(const std::vector<Pair>& pairs) {
    // Each alone is accepted in both forms; so one that is refused is named, and the others are still run.
    std::vector<std::size_t> which;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        bool fine = true;
        for (std::string Pair::* form : {&Pair::literal, &Pair::variable}) {
            const Result<check::Program> program = checked(one_program(pairs, form, {i}));
            EXPECT_TRUE(program) << pairs[i].name << ": " << pairs[i].*form << "\n" << program.error().message();
            fine = fine && program;
        }
        if (fine) which.push_back(i);
    }
    const std::string literal = one_program(pairs, &Pair::literal, which), variable = one_program(pairs, &Pair::variable, which);
    Workshop workshop(Level::Quick);
    const Result<check::Program> program = checked(literal), other = checked(variable);
    ASSERT_TRUE(program && other);
    const Result<Module> module = workshop.module(literal), other_module = workshop.module(variable);
    ASSERT_TRUE(module) << module.error().message();
    ASSERT_TRUE(other_module) << other_module.error().message();
    std::vector<std::size_t> facts(pairs.size());
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        const Trial trial{{.declarations = {}, .rules = {}, .text = literal, .given = {given()}}, retraction::make_case(seed, {given()})};
        Trial varied = trial;
        varied.draft.text = variable;
        const Outcome one = run(trial, *program, info_of(*module), {}, Watch::Reference);
        const Outcome two = run(varied, *other, info_of(*other_module), {}, Watch::Reference);
        EXPECT_EQ(one.trouble, "") << "seed " << seed;
        EXPECT_EQ(two.trouble, "") << "seed " << seed;
        ASSERT_EQ(one.views.size(), two.views.size());
        for (std::size_t burst = 0; burst < one.views.size(); ++burst)
            for (const std::size_t i : which)
                for (const char made : {'q', 'u'}) {
                    const std::string name = made + std::to_string(i);
                    const auto rows = [&](const check::Program& p, const Facts& views) -> const Rows* {
                        for (const PredicateId id : p.predicates.ids())
                            if (p.predicates[id].name == name) return &views[id.index()];
                        return nullptr;
                    };
                    const Rows *first = rows(*program, one.views[burst]), *second = rows(*other, two.views[burst]);
                    ASSERT_EQ(first == nullptr, second == nullptr);
                    if (first == nullptr) continue;
                    EXPECT_TRUE(*first == *second) << pairs[i].name << ", seed " << seed << ", burst " << burst;
                    facts[i] += first->size();
                }
    }
    for (const std::size_t i : which) EXPECT_GT(facts[i], 0u) << pairs[i].name << " derives nothing, so nothing was compared";
}

TEST(FixedCatoms, InViewsAreLikeVariables) { expect_alike(kViews); }
TEST(FixedCatoms, InLinearRulesAreLikeVariables) { expect_alike(kLinear); }

}  // namespace
}  // namespace meld::reference
