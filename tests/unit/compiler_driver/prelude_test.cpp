// stdlib/prelude.meld declares what the tables of actions and senses say, no more and no less.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "compiler/front/front_end.h"
#include "runtime/module/abi/actions.h"
#include "runtime/module/abi/senses.h"

namespace meld::front {
namespace {

using Signature = std::pair<std::string, std::size_t>;  // Of the arguments after the catom.

check::Program prelude() {
    source::FileSet files;
    const std::uint32_t count = add_prelude(files);
    const std::uint32_t program = files.add("empty.meld", "");
    diagnostics::Reporter report;
    check::Program checked = check_program(files, program, count, parse_program(files, program, count, report, {}), report);
    EXPECT_EQ(report.error_count(), 0u);
    return checked;
}

TEST(Prelude, DeclaresTheActionsOfTheTable) {
    std::set<Signature> declared, known;
    for (const check::Predicate& p : prelude().predicates)
        if (p.kind == check::PredicateKind::Action) declared.emplace(p.name, p.arguments.size() - 1);
    for (const ActionInfo& action : known_actions()) known.emplace(action.word, action.arguments);
    EXPECT_EQ(declared, known);
    EXPECT_EQ(known.size(), known_actions().size()) << "an action is twice in the table";
}

TEST(Prelude, DeclaresTheSensesOfTheTable) {
    std::set<Signature> declared, known;
    for (const check::Predicate& p : prelude().predicates)
        if (p.world != WorldSource::None) declared.emplace(p.name, p.arguments.size() - 1);
    for (const SenseName& sense : sense_names()) {
        known.emplace(sense.word, sense.arguments);
        EXPECT_EQ(world_source(sense.word, sense.arguments), sense.source) << sense.word;
    }
    EXPECT_EQ(declared, known);
    EXPECT_EQ(known.size(), sense_names().size()) << "a sense is twice in the table";
}

TEST(Prelude, DeclaresTheSensesOfBodiesOfTheTable) {
    std::set<Signature> declared, known;
    for (const check::Predicate& p : prelude().predicates)
        if (p.sensed && is_body_sense(p.name)) declared.emplace(p.name, p.arguments.size() - 1);
    for (const BodySense& sense : body_senses()) known.emplace(sense.word, sense.arguments);
    EXPECT_EQ(declared, known);
    EXPECT_EQ(known.size(), body_senses().size()) << "a sense of bodies is twice in the table";
}

TEST(Prelude, DeclaresWhatNodesSenseWithinTheirRange) {
    std::set<Signature> declared, known;
    for (const check::Predicate& p : prelude().predicates)
        if (p.sensed && is_range_sense(p.name)) declared.emplace(p.name, p.arguments.size() - 1);
    for (const RangeSense& sense : range_senses()) known.emplace(sense.word, sense.arguments);
    EXPECT_EQ(declared, known);
    EXPECT_EQ(known.size(), range_senses().size()) << "a sense of a range is twice in the table";
}

TEST(Prelude, DeclaresWhatCatomsSenseOfTheirMoves) {
    std::set<Signature> declared, known;
    for (const check::Predicate& p : prelude().predicates)
        if (p.sensed && is_move_sense(p.name)) declared.emplace(p.name, p.arguments.size() - 1);
    for (const MoveSense& sense : move_senses()) known.emplace(sense.word, sense.arguments);
    EXPECT_EQ(declared, known);
    EXPECT_EQ(known.size(), move_senses().size()) << "a sense of moves is twice in the table";
}

TEST(Prelude, HasIntsWhereTheTableHasBounds) {
    for (const check::Predicate& p : prelude().predicates) {
        if (info(p.world).values != SenseInfo::Values::Any) {
            EXPECT_EQ(p.arguments.back().type, check::Type::Int) << p.name;
        }
    }
}

TEST(Prelude, NamesTheCodesOfActionsThatFail) {
    std::map<std::string, std::int64_t> declared, known;
    for (const check::Constant& c : prelude().constants)
        if (c.prelude && c.name.starts_with("failed-")) declared.emplace(c.name, c.integer);
    for (const ActionInfo& action : known_actions())
        if (action.failure != 0) known.emplace("failed-" + std::string(action.word), action.failure);
    EXPECT_EQ(declared, known);
}

}  // namespace
}  // namespace meld::front
