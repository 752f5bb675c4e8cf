// Exactness under change: random programs' worlds change while they run, and whenever they quiesce, what holds is what
// follows from the rules and the present base facts, no more and no less; on any number of processes and threads the state is
// the same after every tick.
//
// CLAYMELD_RETRACTION_SEEDS says how many cases each program gets, CLAYMELD_RETRACTION_FIRST where they begin.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "compiled.h"
#include "run.h"
#include "runtime/world/description/world.h"

namespace meld::retraction {
namespace {

std::uint64_t number_from_environment(const char* name, std::uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

class Retraction : public testing::TestWithParam<Program> {
  protected:
    void SetUp() override {
        Result<Module> module = compiled(GetParam().name);
        ASSERT_TRUE(module) << module.error().message();
        module_ = std::make_unique<Module>(std::move(*module));
    }
    const ModuleInfo& module() const { return info_of(*module_); }
    Outcome run_case(const Case& c, const Setting& setting) const {
        return run(c, GetParam(), module(), expectations(c, GetParam()), setting);
    }

    // The failing case, made small, as text.
    std::string report(const Case& c, const Setting& setting, const std::function<bool(const Case&)>& in_trouble) const {
        const Case small = shrink(c, in_trouble);
        return GetParam().name + ".meld with " + std::to_string(setting.processes) + " processes, " + std::to_string(setting.threads) +
               " threads; from seed " + std::to_string(c.seed) + "\n" + print(small, GetParam().given) + run_case(small, setting).trouble;
    }

  private:
    std::unique_ptr<Module> module_;
};

constexpr Setting kSettings[] = {{1, 2}, {2, 1}, {3, 1}, {4, 1}, {2, 2}, {3, 2}, {4, 2}};

TEST_P(Retraction, LeavesNoTrace) {
    const std::uint64_t count = number_from_environment("CLAYMELD_RETRACTION_SEEDS", 10);
    const std::uint64_t first = number_from_environment("CLAYMELD_RETRACTION_FIRST", 1);
    Outcome sum;
    std::uint64_t ticks = 0, runs = 0;
    for (std::uint64_t seed = first; seed < first + count; ++seed) {
        const Case c = make_case(seed, GetParam().given);
        const std::vector<Facts> expected = expectations(c, GetParam());
        const Outcome alone = run(c, GetParam(), module(), expected, {});
        ASSERT_EQ(alone.trouble, "") << report(c, {}, [&](const Case& less) { return !run_case(less, {}).trouble.empty(); });
        // Every eighth case in all settings, the others with one of them in turn.
        for (std::size_t i = 0; i < std::size(kSettings); ++i) {
            if (seed % 8 != 0 && seed % 8 != i + 1) continue;
            const Setting& setting = kSettings[i];
            const auto differs = [&](const Case& less) { return run_case(less, setting).states != run_case(less, {}).states; };
            const Outcome other = run(c, GetParam(), module(), expected, setting);
            ASSERT_EQ(other.trouble, "") << report(c, setting, [&](const Case& less) { return !run_case(less, setting).trouble.empty(); });
            ASSERT_TRUE(other.states == alone.states) << "other states than alone: " << report(c, setting, differs);
            sum.exchanges += other.exchanges;
            ++runs;
        }
        ++runs;
        sum.retractions += alone.retractions;
        sum.tombstones += alone.tombstones;
        sum.quarantines += alone.quarantines;
        sum.compared += alone.compared;
        ticks += alone.states.size();
    }
    std::printf(
        "%s: %llu cases, %llu runs, %llu ticks a run, %llu facts compared, %llu retracted; %llu catoms remembered losses, %llu ticks of "
        "quarantine alone; processes spoke in %llu ticks\n",
        GetParam().name.c_str(), static_cast<unsigned long long>(count), static_cast<unsigned long long>(runs),
        static_cast<unsigned long long>(ticks / count), static_cast<unsigned long long>(sum.compared),
        static_cast<unsigned long long>(sum.retractions), static_cast<unsigned long long>(sum.tombstones),
        static_cast<unsigned long long>(sum.quarantines), static_cast<unsigned long long>(sum.exchanges));
    if (count < 100) return;
    // The cases have really exercised what they are about.
    EXPECT_GT(sum.compared, 20 * count);
    EXPECT_GT(sum.retractions, count);
    EXPECT_GT(sum.exchanges, count);
    EXPECT_EQ(sum.tombstones > count, GetParam().loses);
    EXPECT_EQ(sum.quarantines > count / 10, GetParam().waits);
}

// A change hidden from the runtime is detected in most cases; some changes have no effect on the facts.
TEST_P(Retraction, NoticesALostChange) {
    int noticed = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed)
        noticed += !run_case(make_case(seed, GetParam().given), {.lose_last_change = true}).trouble.empty();
    EXPECT_GE(noticed, 5);
}

std::string program_name(const testing::TestParamInfo<Program>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(Programs, Retraction, testing::ValuesIn(programs()), program_name);

// Without quarantine phantoms keep each other alive for ever, and the cases show it.
class Quarantine : public Retraction {};
TEST_P(Quarantine, IsNeeded) {
    int noticed = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed)
        noticed += !run_case(make_case(seed, GetParam().given), {.no_quarantine = true}).trouble.empty();
    EXPECT_GE(noticed, 1);
}
INSTANTIATE_TEST_SUITE_P(Programs, Quarantine, testing::ValuesIn({programs()[0], programs()[3]}), program_name);

// Long ways round, and many losses at a time.
class Large : public Retraction {};
TEST_P(Large, AgreesOnAnyNumberOfProcesses) {
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
        std::vector<Given> given = GetParam().given;
        given[0].per_mille = 2;
        const Case c = make_large_case(seed, given);
        const Program& program = GetParam();
        const std::vector<Facts> expected = expectations(c, program);
        const Outcome alone = run(c, program, module(), expected, {}), processes = run(c, program, module(), expected, {4, 1});
        ASSERT_EQ(alone.trouble, "") << print(c, given);
        EXPECT_GT(alone.tombstones, 100u);
        std::size_t same = 0;
        while (same < alone.states.size() && same < processes.states.size() && alone.states[same] == processes.states[same]) ++same;
        EXPECT_TRUE(alone.states == processes.states) << "seed " << seed << ": the states part after tick " << same;
    }
}
INSTANTIATE_TEST_SUITE_P(Programs, Large, testing::ValuesIn({programs()[0]}), program_name);

// Where ranks grow by more than one a tick, a memory of a loss that could have been forgotten may come to matter again, so
// when it is forgotten must not depend on how many others this process remembers. An island loses its source; once that is
// past, a crowd loses theirs in one tick; meanwhile values of great rank run along a line, and a bridge leads them to the island.
TEST(Memory, IsKeptEquallyLongOnAnyNumberOfProcesses) {
    const Program& program = *std::find_if(programs().begin(), programs().end(), [](const Program& p) { return p.name == "mutual"; });
    const Result<Module> module = compiled(program.name);
    ASSERT_TRUE(module) << module.error().message();
    Case c{.seed = 0, .lattice = world::LatticeKind::Square, .cells = {}, .bursts = {{}}};
    std::vector<Change>& changes = c.bursts[0];
    const auto give = [&](int tick, Cell cell, std::size_t given, Row arguments) {
        changes.push_back({.kind = Change::Kind::Give, .tick = tick, .cell = cell, .given = given, .arguments = std::move(arguments)});
    };
    std::vector<Cell> crowd;
    for (std::int32_t y = 10; y < 40; ++y)
        for (std::int32_t x = 0; x < 40; ++x) crowd.push_back({x, y, 0});
    std::vector<Cell> walked = {{20, 2, 0}, {21, 2, 0}, {20, 3, 0}, {21, 3, 0}};
    for (std::int32_t x = 0; x < 100; ++x) walked.push_back({x, 0, 0});
    for (const Cell& cell : crowd) give(0, cell, 0, {});
    for (const Cell& cell : walked) give(0, cell, 1, {3});
    give(0, {20, 2, 0}, 0, {});
    changes.push_back({.kind = Change::Kind::Take, .tick = 20, .cell = {20, 2, 0}});
    for (const Cell& cell : crowd) changes.push_back({.kind = Change::Kind::Take, .tick = 31, .cell = cell});
    give(31, {0, 0, 0}, 0, {});
    changes.push_back({.kind = Change::Kind::Add, .tick = 53, .cell = {20, 1, 0}});
    give(53, {20, 1, 0}, 1, {3});
    c.cells = crowd;
    c.cells.insert(c.cells.end(), walked.begin(), walked.end());
    world::sort_cells(c.cells, world::Lattice(c.lattice));
    const std::vector<Facts> expected = expectations(c, program);
    const Outcome alone = run(c, program, info_of(*module), expected, {}), processes = run(c, program, info_of(*module), expected, {4, 1});
    EXPECT_EQ(alone.trouble, "");
    EXPECT_EQ(processes.trouble, "");
    EXPECT_TRUE(alone.states == processes.states);
}

}  // namespace
}  // namespace meld::retraction
