// For which programs linear facts may be variables while a catom holds one of each, and why not for others.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "compiler/emit/emit.h"
#include "compiler/emit/marks.h"
#include "compiler/plan/plan.h"
#include "tests/unit/compiler_plan/planned.h"

namespace meld::plan {
namespace {

constexpr const char* kFacts =
    "type linear p(node, int).\ntype linear q(node, int).\ntype linear m(node, int).\ntype seen(node, int).\n"
    "type set(node, int).\nfun twice(int X) : int = X * 2.\n";

std::vector<std::string> names(const Plan& plan, const std::vector<PredicateId>& predicates) {
    std::vector<std::string> all;
    for (const PredicateId p : predicates) all.push_back(plan.program.predicates[p].name);
    std::ranges::sort(all);
    return all;
}
Plan plan_of_rules(const std::string& rules) {
    std::string facts = kFacts;
    // A function alone would be an obstacle.
    if (rules.find("twice(") == std::string::npos) facts.resize(facts.find("fun "));
    return plan_of(facts + rules);
}

TEST(Singles, AreTheStatesOfACatom) {
    const Plan plan = plan_of_rules(
        "q(A, X), X > 0 -o { B | neighbor(A, B) | m(B, X) }, p(A, X - 1).\n"
        "p(A, X), m(A, Y) -o p(A, X + Y).\n");
    EXPECT_EQ(plan.singles.obstacle, "");
    EXPECT_EQ(names(plan, plan.singles.facts), (std::vector<std::string>{"p", "q"}));
    EXPECT_EQ(names(plan, plan.singles.messages), std::vector<std::string>{"m"});
}

// Several rules may sweep them. A rule that reads or makes one by itself makes them facts like all others.
TEST(Singles, LeaveOutMessagesThatAreOnlySwept) {
    const std::string two = "p(A, X), m(A, Y) -o p(A, X + Y).\nq(A, X), m(A, Y), Y > 3 -o q(A, X - Y).\n";
    EXPECT_EQ(names(plan_of_rules(two), plan_of_rules(two).singles.messages), std::vector<std::string>{"m"});
    for (const std::string more :
         {"m(A, X), X > 5 -o q(A, X).\n", "q(A, X) -o m(A, X), m(A, X).\n", "q(A, X), not m(A, 3) -o p(A, X).\n"}) {
        const Plan plan = plan_of_rules(two + more);
        EXPECT_TRUE(plan.singles.messages.empty()) << more;
    }
    // It also makes something else, which could not be forgotten.
    EXPECT_TRUE(plan_of_rules("p(A, X), m(A, Y), neighbor(A, B) -o p(A, X + Y), m(B, Y).\n").singles.messages.empty());
}

struct Refused {
    const char* rules;
    const char* obstacle;
};
constexpr Refused kRefused[] = {
    {"p(A, X) -o q(A, X).\nseen(B, X) :- set(A, X), neighbor(A, B).\n", "the program has views"},
    {"p(A, X) -o q(A, twice(X)).\n", "the program has functions"},
    {"[desc => X | p(A, X)] -o q(A, X).\n", "chooses among facts"},
    {"p(A, X) -o seen(A, X).\n", "seen is not linear"},
    {"p(A, X), set(A, X) -o q(A, X).\n", "set is not linear"},
    {"p(A, X), p(A, Y), X < Y -o p(A, X).\n", "a rule reads two p"},
    {"p(A, X) -o q(A, X), q(A, X + 1).\n", "makes several q"},
    {"p(A, X) -o (if X > 3 then q(A, X) otherwise m(A, X) end).\n", "does not always make one q"},
    {"p(A, X) -o { Y | q(A, Y) | m(A, Y) }.\n", "a comprehension reads q"},
    {"p(A, X) -o { B | neighbor(A, B) | q(A, X) }.\n", "does not always make one q"},
    {"p(A, X) -o q(A, randint(X)).\n", "what a rule draws depends on how often it is tried"},
    {"p(A, X), X > randint(9) -o q(A, X).\n", "what a rule draws depends on how often it is tried"},
};

TEST(Singles, SayWhyFactsAreInLists) {
    for (const auto& [rules, obstacle] : kRefused) {
        const Plan plan = plan_of_rules(rules);
        EXPECT_NE(plan.singles.obstacle.find(obstacle), std::string::npos) << rules << plan.singles.obstacle;
        EXPECT_FALSE(plan.singles.apply()) << rules;
        EXPECT_NE(explain(plan).find(plan.singles.obstacle), std::string::npos) << rules;
        EXPECT_EQ(emit::emit_module(plan).find("struct Singles"), std::string::npos) << rules;
    }
    std::string nine;
    for (int i = 0; i < 9; ++i) nine += "p(A, " + std::to_string(i) + ") -o q(A, " + std::to_string(i) + ").\n";
    EXPECT_EQ(plan_of_rules(nine).singles.obstacle, "there are more than 8 linear rules");
    const Plan views = plan_of_rules("seen(B, X) :- set(A, X), neighbor(A, B).\n");
    EXPECT_TRUE(views.singles.obstacle.empty() && !views.singles.apply());
}

// The rules that are to be tried again are then known beforehand, which evaluate_singles() relies on.
TEST(Singles, AreOnlyWhereMarksAreFixed) {
    for (const char* rules :
         {"p(A, X), not q(A, _), X > 0 -o q(A, X), { B | neighbor(A, B) | m(B, X) }, (if X > 2 then setColor(A, X, 1, 2) otherwise 1 "
          "end).\n"
          "q(A, X), m(A, Y) -o q(A, X + Y).\n",
          "p(A, X), neighbor(A, B), neighborCount(A, N) -o m(B, X + N).\nm(A, X), X > 0 -o p(A, X - 1).\n", "p(A, _) -o 1.\n"}) {
        const Plan plan = plan_of_rules(rules);
        EXPECT_TRUE(plan.singles.apply()) << rules << plan.singles.obstacle;
        EXPECT_TRUE(emit::fixed_marks(plan)) << rules;
        EXPECT_NE(emit::emit_module(plan).find("struct Singles"), std::string::npos) << rules;
    }
}

}  // namespace
}  // namespace meld::plan
