#include "compiler/plan/picks.h"

#include <gtest/gtest.h>

#include "tests/unit/compiler_plan/planned.h"

namespace meld::plan {
namespace {

using check::Aggregate;

// Of the function f in a program where it folds the ids of the neighbours.
std::optional<Aggregate> picked(const std::string& function, const std::string& type = "int",
                                const std::string& rules = "p(A, I) :- neighbor(A, B), id(B, I).") {
    const Plan plan = plan_of(function + "\ntype p(node, f " + type + ").\n" + rules + "\n");
    for (const PredicateId id : plan.program.predicates.ids())
        if (plan.program.predicates[id].name == "p") return picks(plan, id);
    throw std::runtime_error("there is no p");
}

TEST(Picks, TheLeastOrTheGreatestOfTwoInts) {
    const auto written = [](const std::string& body) { return picked("fun f(int A, int B) : int = " + body + "."); };
    for (const char* least : {"if A < B then A else B end", "if A <= B then A else B end", "if A > B then B else A end",
                              "if B > A then A else B end", "if B < A then B else A end", "min(A, B)", "min(B, A)"})
        EXPECT_EQ(written(least), Aggregate::Min) << least;
    for (const char* greatest : {"if A < B then B else A end", "if A > B then A else B end", "if B >= A then B else A end", "max(A, B)"})
        EXPECT_EQ(written(greatest), Aggregate::Max) << greatest;
    for (const char* other : {"if A < B then A else A end", "if A < A then A else B end", "if A < B then A else B + 1 end",
                              "if A = B then A else B end", "if A < 3 then A else B end", "min(A, A)", "A + B", "A"})
        EXPECT_EQ(written(other), std::nullopt) << other;
}

TEST(Picks, NothingElse) {
    EXPECT_EQ(
        picked("fun f(float A, float B) : float = if A < B then A else B end.", "float", "p(A, 1.0 * I) :- neighbor(A, B), id(B, I)."),
        std::nullopt);
}

// Where the value depends on itself over links.
TEST(Picks, AlsoWhereItIsComputedAnewFromTheNeighbours) {
    EXPECT_EQ(picked("fun f(int A, int B) : int = if A < B then A else B end.", "int",
                     "p(A, I) :- id(A, I), I = 0.\np(A, C + 1) :- neighbor(A, B), p(B, C), C < 20."),
              Aggregate::Min);
}

}  // namespace
}  // namespace meld::plan
