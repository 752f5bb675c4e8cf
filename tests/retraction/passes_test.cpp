// What the planner leaves out when it is asked to changes no result: each program with and without a pass has the same
// facts, ranks and memories of losses after every tick, on any number of processes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

#include "compiled.h"
#include "compiler/plan/plan.h"
#include "run.h"

namespace meld::retraction {
namespace {

// A program whose rules are compared with nothing but themselves.
Program rows() {
    const auto arguments = [](std::int64_t keys, std::int64_t values) {
        return std::vector<std::pair<std::int64_t, std::int64_t>>{{1, keys}, {0, values}};
    };
    return {.name = "rows",
            .given = {{.predicate = "item", .arguments = arguments(6, 5), .per_mille = 700},
                      {.predicate = "item", .arguments = arguments(6, 5), .per_mille = 600},
                      {.predicate = "item", .arguments = arguments(6, 5), .per_mille = 600},
                      {.predicate = "pair", .arguments = arguments(6, 6), .per_mille = 500},
                      {.predicate = "off", .arguments = {{1, 6}}, .per_mille = 200},
                      {.predicate = "token", .arguments = {{1, 6}}, .per_mille = 100, .linear = true, .becomes = "mark"}},
            .aggregates = {},
            .strata = {}};
}

class Passes : public testing::TestWithParam<Program> {};

// Where a wait was for nothing, one side may note it and the other not: the shorter run is how the longer begins, and what
// comes after is its last state over and over.
bool same_course(std::vector<Digest> a, std::vector<Digest> b) {
    if (a.size() > b.size()) std::swap(a, b);
    for (std::size_t i = 0; i < b.size(); ++i)
        if (!(b[i] == (i < a.size() ? a[i] : a[a.size() - 2 + (i - a.size()) % 2]))) return false;
    return true;
}

// How many cases; few where the pass has little to do with evaluation.
void compare(const Program& program, const std::string& pass, std::uint64_t cases, std::uint64_t& derived_with,
             std::uint64_t& derived_without) {
    // What is left out runs less often than it takes the compiler to optimise it.
    const Result<Module> with = compiled(program.name), without = compiled(program.name, "-O0 --without " + pass);
    ASSERT_TRUE(with) << with.error().message();
    ASSERT_TRUE(without) << without.error().message();
    for (std::uint64_t seed = 1; seed <= cases; ++seed) {
        const Case c = make_case(seed, program.given);
        const std::vector<Facts> nothing(c.bursts.size());
        const auto one_way = [&](const Case& less, const Result<Module>& module, Setting setting) {
            return run(less, program, info_of(*module), nothing, setting);
        };
        const Setting alone{.deep = true};
        const auto differs = [&](const Case& less) {
            return !same_course(one_way(less, with, alone).states, one_way(less, without, alone).states);
        };
        const Outcome a = one_way(c, with, alone), b = one_way(c, without, alone);
        ASSERT_EQ(a.trouble, "");
        ASSERT_TRUE(same_course(a.states, b.states)) << program.name << ".meld without " << pass << ", seed " << seed << "\n"
                                                     << print(shrink(c, differs), program.given);
        if (seed % 4 == 0) {
            const Setting processes{
                .processes = 2 + static_cast<int>(seed) % 3, .threads = 1 + static_cast<int>(seed / 4) % 2, .deep = true};
            const Outcome divided = one_way(c, with, processes);
            ASSERT_TRUE(divided.states == a.states)
                << "other states on " << processes.processes << " processes: " << program.name << ".meld, seed " << seed;
            ASSERT_EQ(divided.derivations, a.derivations)
                << "on " << processes.processes << " processes: " << program.name << ".meld, seed " << seed;
        }
        derived_with += a.derivations;
        derived_without += b.derivations;
    }
}

TEST_P(Passes, DeltasChangeNothing) {
    std::uint64_t with = 0, without = 0;
    compare(GetParam(), "deltas", 60, with, without);
    const std::string& name = GetParam().name;
    std::printf("%s: %llu derivations, %llu without deltas\n", name.c_str(), static_cast<unsigned long long>(with),
                static_cast<unsigned long long>(without));
    EXPECT_LE(with, without);
    if (name == "rows" || name == "keyed" || name == "flood") {
        EXPECT_LT(with, without);
    }
}

// Ranks may be others where facts pass fewer auxiliaries, but no auxiliary is recursive here.
TEST(Rewriting, ChangesNothing) {
    for (const std::string_view name : plan::passes(plan::Passes::Optional)) {
        const std::string pass(name);
        if (pass == "deltas") continue;  // Above.
        std::uint64_t with = 0, without = 0;
        compare(rows(), pass, 8, with, without);
        std::printf("%llu derivations, %llu without %s\n", static_cast<unsigned long long>(with), static_cast<unsigned long long>(without),
                    pass.c_str());
        // The best of a neighbour's rows is found there, before anybody asks: that spares messages, not always derivations.
        if (pass != "push") {
            EXPECT_LE(with, without);
        }
    }
}

std::vector<Program> all_programs() {
    std::vector<Program> all{rows()};
    all.insert(all.end(), programs().begin(), programs().end());
    return all;
}

std::string pass_name(const testing::TestParamInfo<Program>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(Programs, Passes, testing::ValuesIn(all_programs()), pass_name);

}  // namespace
}  // namespace meld::retraction
