#include "compiler/emit/marks.h"

#include <gtest/gtest.h>

#include "compiler/emit/emit.h"
#include "tests/unit/compiler_plan/planned.h"

namespace meld::emit {
namespace {

constexpr const char* kPassedOn =
    "type linear rank(node, float).\n"
    "type linear gain(node, float).\n"
    "rank(A, 0.0).\n"
    "gain(A, G), rank(A, E) -o rank(A, E + G).\n"
    "rank(A, E), E > 1.0 -o rank(A, 0.0), { B | neighbor(A, B) | gain(B, E / 6.0) }.\n";

TEST(Marks, OfARuleAreThoseOfWhatItMakesAndConsumesHere) {
    const plan::Plan plan = plan::plan_of(kPassedOn);
    ASSERT_EQ(plan.linear_rules.size(), 2U);
    EXPECT_TRUE(fixed_marks(plan));
    const std::optional<Marks> adds = marks_of(plan, plan.linear_rules[0]), passes_on = marks_of(plan, plan.linear_rules[1]);
    ASSERT_TRUE(adds && passes_on);
    EXPECT_EQ(adds->made, passes_on->made);  // The rank. What is sent changes nothing here.
    EXPECT_NE(adds->consumed, passes_on->consumed);
    EXPECT_EQ(adds->consumed & passes_on->consumed, adds->made);
    for (const RulePlan& r : plan.linear_rules) EXPECT_TRUE(wakes(*adds, r));
}

TEST(Marks, WakeARuleThatWaitsUntilAFactIsGone) {
    const plan::Plan plan = plan::plan_of(
        "type linear busy(node).\ntype linear job(node).\ntype linear done(node).\n"
        "busy(A) -o done(A).\njob(A), not busy(A) -o busy(A).\n");
    ASSERT_EQ(plan.linear_rules.size(), 2U);
    EXPECT_TRUE(fixed_marks(plan));
    EXPECT_TRUE(wakes(*marks_of(plan, plan.linear_rules[0]), plan.linear_rules[1]));
    EXPECT_TRUE(wakes(*marks_of(plan, plan.linear_rules[1]), plan.linear_rules[0]));
    EXPECT_FALSE(wakes(*marks_of(plan, plan.linear_rules[0]), plan.linear_rules[0]));
}

// Made or consumed any number of times, there already, only in one case; and where a view reads what changes.
TEST(Marks, AreNotKnownBeforehandWhereTheyDependOnTheFacts) {
    for (const char* rule : {"p(A, X) -o { Y | q(A, Y) | q(A, Y + X) }.", "p(A, X) -o seen(A, X).",
                             "p(A, X) -o if X > 3 then q(A, X) otherwise r(A, X) end.", "p(A, X) -o { Y | q(A, Y) | 1 }, r(A, X)."}) {
        const plan::Plan plan = plan::plan_of(
            std::string("type linear p(node, int).\ntype linear q(node, int).\ntype linear r(node, int).\ntype seen(node, int).\n") + rule);
        EXPECT_FALSE(fixed_marks(plan)) << rule;
        EXPECT_NE(emit_module(plan).find("s.raised |="), std::string::npos) << rule;
    }
    EXPECT_FALSE(
        fixed_marks(plan::plan_of(std::string(kPassedOn) + "type far(node, min int).\nfar(B, D + 1) :- neighbor(A, B), far(A, D).\n")));
    EXPECT_EQ(emit_module(plan::plan_of("type linear p(node, int).\np(A, X), X > 0 -o p(A, X - 1).\n")).find("s.raised |="),
              std::string::npos);
}

}  // namespace
}  // namespace meld::emit
