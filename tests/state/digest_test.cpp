// The digest that is kept by changes: what it says of a catom whose change nobody has told it of, and that it finds its way again.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "run_fixture.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/results/record/state_digest.h"
#include "runtime/sim/core/tick.h"

namespace meld {
namespace {

class RunningDigest : public ProgramTest {};

TEST_P(RunningDigest, SaysWhichCatomHasChangedUnnoticed) {
    const auto comm = comm::make_single();
    const ModuleInfo& module = *static_cast<const ModuleInfo*>(module_->table());
    sim::Subdomain subdomain(module, world_, *target_, *comm, 1);
    ASSERT_TRUE(subdomain.populate().has_value());
    sim::Tick tick(subdomain);
    record::RunningDigest running;
    for (int i = 0; i < 5; ++i) {
        tick.begin();
        tick.end();
        EXPECT_EQ(running.of(subdomain), record::state_digest(subdomain));
        ASSERT_TRUE(running.check(subdomain).has_value());
    }
    const u32 source = *tuple::find_predicate(module, "source", 0);
    const auto write = [&](u64 id) {
        // What no code of a run can do: it changes a column and marks nobody.
        auto& columns = const_cast<tuple::Columns&>(subdomain.columns);
        ASSERT_TRUE(tuple::give_fact(module, columns, source, *subdomain.ensemble.find(id), nullptr, 0));
    };
    write(70), write(31);
    EXPECT_NE(running.of(subdomain), record::state_digest(subdomain));
    const Result<void> wrong = running.check(subdomain);
    ASSERT_FALSE(wrong.has_value());
    EXPECT_THAT(wrong.error().message(), testing::HasSubstr("the digest of tick 5 "));
    EXPECT_THAT(wrong.error().message(), testing::HasSubstr("first at catom @31"));
    EXPECT_EQ(wrong.error().code, ExitCode::OurBug);
    for (const u64 id : {70, 31}) subdomain.mark(*subdomain.ensemble.find(id), kDirtyLinks);
    EXPECT_EQ(running.of(subdomain), record::state_digest(subdomain));
    EXPECT_TRUE(running.check(subdomain).has_value());
}

// The same of a fact that is given as events give it, of two digests that look at it at different times.
TEST_P(RunningDigest, FollowsByItself) {
    const auto comm = comm::make_single();
    const ModuleInfo& module = *static_cast<const ModuleInfo*>(module_->table());
    sim::Subdomain subdomain(module, world_, *target_, *comm, 2);
    ASSERT_TRUE(subdomain.populate().has_value());
    sim::Tick tick(subdomain);
    record::RunningDigest often, seldom;
    const u32 source = *tuple::find_predicate(module, "source", 0);
    for (u32 i = 0; i < 40; ++i) {
        tick.begin();
        if (i % 10 == 7) subdomain.take(source, i / 10, nullptr);
        if (i % 10 == 3) subdomain.give(source, i, nullptr);
        tick.end();
        const Digest whole = record::state_digest(subdomain);
        EXPECT_EQ(often.of(subdomain), whole) << "tick " << subdomain.tick();
        if (i % 7 == 0) {
            EXPECT_EQ(seldom.of(subdomain), whole) << "tick " << subdomain.tick();
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Programs, RunningDigest, testing::Values(Program{"gradient", 40}), program_name);

}  // namespace
}  // namespace meld
