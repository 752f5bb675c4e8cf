// Predicates of a program that are actions of the runtime: by kind, name and number of arguments.
#include "runtime/engine/tuple/program_actions.h"

#include <gtest/gtest.h>

#include <optional>

namespace meld::tuple {
namespace {

PredicateInfo predicate(const char* name, PredicateKind kind, u16 arity) {
    PredicateInfo p{};
    p.name = name;
    p.kind = kind;
    p.arity = arity;
    return p;
}

TEST(ProgramActions, AreFoundByKindNameAndNumberOfArguments) {
    const PredicateInfo predicates[] = {
        predicate("force", PredicateKind::Action, 1),        predicate("force", PredicateKind::Action, 3),
        predicate("create", PredicateKind::Linear, 1),       predicate("stop-program", PredicateKind::Action, 1),
        predicate("stop-program", PredicateKind::Action, 0), predicate("dance", PredicateKind::Action, 1),
    };
    ModuleInfo module{};
    module.predicates = predicates;
    module.predicate_count = 6;
    const ProgramActions actions(module);
    EXPECT_EQ(actions.kind_of(0), ActionKind::ForceVector);
    EXPECT_EQ(actions.kind_of(1), ActionKind::Force);
    EXPECT_EQ(actions.kind_of(2), ActionKind::None) << "a fact of that name is no action";
    EXPECT_EQ(actions.kind_of(3), ActionKind::None) << "nor is an action of the program with another number of arguments";
    EXPECT_EQ(actions.kind_of(4), ActionKind::StopProgram);
    EXPECT_EQ(actions.kind_of(5), ActionKind::None);
    EXPECT_EQ(actions.predicate_of(ActionKind::Force), std::optional<u32>(1));
    EXPECT_TRUE(actions.uses(ActionKind::StopProgram));
    EXPECT_FALSE(actions.uses(ActionKind::Create));
}

TEST(ProgramActions, HaveWhatTheTableSays) {
    EXPECT_TRUE(info(ActionKind::Create).has(ActionInfo::kCreates));
    EXPECT_FALSE(info(ActionKind::Create).has(ActionInfo::kTeleports));
    EXPECT_EQ(info(ActionKind::MoveAround).failure, 7);
    EXPECT_EQ(info(ActionKind::None).performer, ActionInfo::Performer::None);
    for (const ActionInfo& action : known_actions()) EXPECT_EQ(&info(action.kind), &action) << action.word;
}

}  // namespace
}  // namespace meld::tuple
