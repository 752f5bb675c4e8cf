// The room that a store of facts has.
#include "runtime/sim/catoms/fact_store.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "run_fixture.h"

namespace meld::sim {
namespace {

// Room is made ahead for mailboxes of a network, and catoms that come later ask for as much as they need themselves.
TEST(FactStore, NeverLosesRoom) {
    const Result<std::string> path = driver::compile_program({.program = kGradient + ".meld"});
    ASSERT_TRUE(path) << path.error().message();
    const Result<Module> module = load_module(*path, kAbiVersion);
    ASSERT_TRUE(module) << module.error().message();
    Workers workers(1);
    FactStore facts(*static_cast<const ModuleInfo*>(module->table()), workers, {});
    constexpr u32 kRoom = 10000, kLast = kRoom - 1;
    facts.resize(kRoom);
    facts.evaluator.agenda().mark(kLast, kDirtyWake);
    facts.resize(10);
    EXPECT_EQ(facts.columns.count(), kRoom);
    std::vector<u32> marked;
    facts.evaluator.agenda().each([&](u32 catom, u64) { marked.push_back(catom); });
    EXPECT_EQ(marked, std::vector<u32>{kLast});
}

}  // namespace
}  // namespace meld::sim
