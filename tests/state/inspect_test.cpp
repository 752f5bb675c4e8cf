// What questions about a run stand on: searches of a rule's body from its head, with facts of lower rank only, in two states of a run at
// once, and how far a search came that found nothing; on any number of processes.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "run_fixture.h"
#include "runtime/ask/facts/all_facts.h"
#include "runtime/ask/query/query.h"
#include "runtime/ask/query/sieve.h"
#include "runtime/ask/query/solver.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/results/timeline/timeline.h"

namespace meld::inspect {
namespace {

class Inspect : public ProgramTest {
  protected:
    // The run after `tick`, beside the one before, on so many processes; the question is asked by the first of them.
    void ask_after(std::int64_t tick, int processes, const std::function<void(sim::Subdomain&, std::span<Facts* const>)>& question) {
        comm::run_threads_as_processes(processes, [&](comm::Communicator& comm) {
            const auto make = [&] {
                return std::make_unique<sim::Simulation>(*static_cast<const ModuleInfo*>(module_->table()), world_, *target_, comm, 1);
            };
            timeline::Timeline run(make, registry_);
            ASSERT_TRUE(run.start());
            ASSERT_TRUE(run.to(tick));
            const auto before = run.beside(tick - 1);
            ASSERT_TRUE(before);
            sim::Subdomain& now = run.simulation().subdomain();
            const std::array states = {&now, &(*before)->subdomain()};
            const Result<void> asked = ask(states, [&](std::span<Facts* const> facts) -> Result<void> {
                question(now, facts);
                return {};
            });
            EXPECT_TRUE(asked) << asked.error().message();
        });
    }
    // Errors of the question reach all processes.
    const sim::Registry registry_ = sim::Registry::standard();
};

struct Dist {
    u64 catom;
    i64 value;
    u32 rank;
    bool operator==(const Dist&) const = default;
};

check::PredicateId named(const check::Program& program, std::string_view name) {
    const auto ids = program.predicates.ids();
    return *std::ranges::find_if(ids, [&](check::PredicateId id) { return program.predicates[id].name == name; });
}

// dist(B, D + 1) :- neighbor(A, B), dist(A, D).
const check::Rule& step_of(const Program& program) {
    const auto rule = std::ranges::find_if(program.checked().rules, [](const check::Rule& r) { return r.body.size() == 2; });
    return *rule;
}
check::VariableId variable(const check::Rule& rule, std::string_view name) {
    const auto ids = rule.variables.ids();
    return *std::ranges::find_if(ids, [&](check::VariableId id) { return rule.variables[id].name == name; });
}

std::vector<Dist> all(Facts& facts, const Source& source) {
    std::vector<Dist> found;
    facts.each(source, [&](const Fact& f) {
        found.push_back({f.catom, f.arguments[0].integer, f.rank});
        return true;
    });
    return found;
}

TEST_P(Inspect, FindsWhatAFactFollowsFrom) {
    std::vector<Dist> alone;
    for (const int processes : {1, 2, 3})
        ask_after(9, processes, [&](sim::Subdomain& subdomain, std::span<Facts* const> facts) {
            const Result<Program> program = Program::read(subdomain.module, "");
            ASSERT_TRUE(program) << program.error().message();
            const Source& dist = program->source(named(program->checked(), "dist"));
            const std::vector<Dist> now = all(*facts[0], dist), before = all(*facts[1], dist);
            if (alone.empty()) alone = now;
            EXPECT_EQ(now, alone);
            // The state before is that of the tick before, at the same time.
            EXPECT_GT(now.size(), before.size());
            for (const Dist& d : before) EXPECT_NE(std::ranges::find(now, d), now.end());

            const check::Rule& rule = step_of(*program);
            const check::VariableId there = variable(rule, "B"), value = variable(rule, "D");
            Terms terms(*program, subdomain.view());
            Solver solver(*program, *facts[0], terms);
            int checked = 0, ways = 0, lower = 0;
            for (const Dist& d : now) {
                if (d.value == 0 || ++checked > 60) continue;
                Values values(rule.variables.count());
                Bound bound(rule.variables.count(), false);
                values[there.index()] = {.catom = d.catom};
                bound[there.index()] = true;
                bool supported = false;
                ASSERT_NE(d.rank, kAbsent);
                const SearchOptions lower_only{.allowed = [&](const check::Clause& clause, const Fact& fact) {
                    return program->source(clause.atom.predicate) != dist || fact.rank < d.rank;
                }};
                for (const SearchOptions& options : {SearchOptions{}, lower_only}) {
                    const auto searched = solver.search(
                        rule, rule.body, values, bound,
                        [&](const Solution& found) {
                            // The facts that were matched, by their place in the body.
                            EXPECT_EQ(found.facts.size(), 2u);
                            EXPECT_EQ(found.facts[0]->arguments[0].catom, d.catom);
                            EXPECT_EQ(found.facts[1]->catom, found.facts[0]->catom);
                            EXPECT_EQ(found.facts[1]->arguments[0].integer, found.values[value.index()].integer);
                            const bool low = options.allowed != nullptr;
                            ++(low ? lower : ways);
                            supported = supported || (low && found.values[value.index()].integer + 1 == d.value);
                            return true;
                        },
                        options);
                    EXPECT_TRUE(searched);
                }
                EXPECT_TRUE(supported) << "dist(@" << d.catom << ", " << d.value << ")";
            }
            EXPECT_GT(checked, 40);
            // Some neighbours are further away, and follow from it.
            EXPECT_GT(ways, lower);
        });
}

TEST_P(Inspect, SaysHowFarItCame) {
    for (const int processes : {1, 2})
        ask_after(9, processes, [&](sim::Subdomain& subdomain, std::span<Facts* const> facts) {
            const Result<Program> program = Program::read(subdomain.module, "dist(A, D), D > 4, neighbor(A, B), dist(B, E), E > D + 1");
            ASSERT_TRUE(program) << program.error().message();
            const check::Rule& question = program->question();
            Terms terms(*program, subdomain.view());
            Solver solver(*program, *facts[0], terms);
            Attempt best;
            int found = 0;
            const auto searched =
                solver.search(question, question.body, {}, {}, [&](const Solution&) { return ++found, true; }, {.best = &best});
            ASSERT_TRUE(searched);
            EXPECT_EQ(found, 0);
            // All but the last condition can be satisfied together.
            EXPECT_EQ(best.taken, 4u);
            EXPECT_EQ(best.failed, &question.body[4]);
            for (const char* name : {"A", "D", "B", "E"}) EXPECT_TRUE(best.bound[variable(question, name).index()]) << name;
            EXPECT_GT(best.values[variable(question, "D").index()].integer, 4);
            EXPECT_LE(best.values[variable(question, "E").index()].integer, best.values[variable(question, "D").index()].integer + 1);

            Attempt early;
            const auto nothing = solver.search(question, question.body, {}, {}, [](const Solution&) { return true; },
                                               {.allowed = [](const check::Clause&, const Fact&) { return false; }, .best = &early});
            ASSERT_TRUE(nothing);
            EXPECT_EQ(early.taken, 0u);
            EXPECT_EQ(early.failed, &question.body[0]);
        });
}

TEST_P(Inspect, TellsAllProcessesOfAnError) {
    comm::run_threads_as_processes(3, [&](comm::Communicator& comm) {
        sim::Simulation simulation(*static_cast<const ModuleInfo*>(module_->table()), world_, *target_, comm, 1);
        ASSERT_TRUE(simulation.start(registry_));
        const Result<Table> wrong = query(simulation.subdomain(), "dist(A)");
        ASSERT_FALSE(wrong);
        EXPECT_NE(wrong.error().problem.find("`dist` has 2 arguments"), std::string::npos);
        const Result<Table> right = query(simulation.subdomain(), "source(A)");
        ASSERT_TRUE(right);
        EXPECT_EQ(right->rows(), comm.process() == 0 ? 1u : 0u);
    });
}

class TablesAtACatom : public Inspect {};

TEST_P(TablesAtACatom, AreLookedThroughAFewTimes) {
    // Each row of one table meets one of the other: a search through all of it for each would look at some hundred million facts.
    const auto few = [](std::uint64_t rows) { return 8 * rows + (1 << 15); };
    for (const std::uint64_t rows : {std::uint64_t{30}, std::uint64_t{2'000}, std::uint64_t{20'000}}) {
        world_.set["rows"] = std::to_string(rows);
        for (const auto& [body, found] : {std::pair<const char*, std::uint64_t>{"near(A, X, Y), far(A, Y, Z)", rows},
                                          {"near(A, X, Y), not far(A, Y, X)", rows},
                                          {"near(A, X, Y), X < 6, far(A, Z + 0, X), Z = Y", 0},
                                          {"near(A, X, Y), N = count : { far(A, Y, _) }, N <> 1", 0}})
            for (const int processes : {1, 2})
                comm::run_threads_as_processes(processes, [&](comm::Communicator& comm) {
                    sim::Simulation simulation(*static_cast<const ModuleInfo*>(module_->table()), world_, *target_, comm, 1);
                    ASSERT_TRUE(simulation.start(registry_));
                    ASSERT_TRUE(simulation.run({}, [] {}));
                    std::uint64_t looked = 0;
                    const Result<Table> table = query(simulation.subdomain(), body, [&](std::uint64_t facts) { looked = facts; });
                    ASSERT_TRUE(table) << table.error().message();
                    EXPECT_LE(looked, few(rows)) << body;
                    EXPECT_LE(table->rows(), found > 0 ? found : rows) << body;
                });
    }
}

TEST_P(TablesAtACatom, AreLookedUpBySieves) {
    for (const std::uint64_t rows : {std::uint64_t{30}, std::uint64_t{2'000}, std::uint64_t{20'000}}) {
        world_.set["rows"] = std::to_string(rows);
        comm::run_threads_as_processes(1, [&](comm::Communicator& comm) {
            sim::Simulation simulation(*static_cast<const ModuleInfo*>(module_->table()), world_, *target_, comm, 1);
            ASSERT_TRUE(simulation.start(registry_));
            ASSERT_TRUE(simulation.run({}, [] {}));
            for (const auto& [body, holds] : {std::pair{"near(A, X, Y), far(A, Y, Z), Z < 0", false},
                                              {"near(A, X, Y), far(A, Y, X)", true},
                                              {"near(A, X, Y), not far(A, Y, X)", true},
                                              {"near(A, X, Y), not (far(A, Z, X), near(A, X, _))", false},
                                              {"near(A, X, Y), N = count : { far(A, Z, X), near(A, Z, _) }, N > 1", false},
                                              {"far(A, X, 7), near(A, 7, Y), Y = X", false}}) {
                const Result<Program> program = Program::read(simulation.subdomain().module, body);
                ASSERT_TRUE(program) << program.error().message();
                const check::Rule& question = program->question();
                Sieve sieve(*program, question, variable(question, "A"), simulation.subdomain());
                ASSERT_FALSE(sieve.idle());
                const std::vector<std::uint32_t> catoms = {0};
                Terms terms(*program, simulation.subdomain().view());
                const Result<Table> table = query(simulation.subdomain(), body);
                ASSERT_TRUE(table) << table.error().message();
                EXPECT_EQ(sieve.pass(catoms).size(), table->rows() > 0 ? 1u : 0u) << body;
                if (rows > 30) {
                    EXPECT_EQ(table->rows() > 0, holds) << body;
                }
                EXPECT_LE(sieve.rows_made(), 16 * rows + 4096) << body;
            }
        });
    }
}

INSTANTIATE_TEST_SUITE_P(Programs, TablesAtACatom, testing::Values(meld::Program{kOwn + "tables"}), program_name);
INSTANTIATE_TEST_SUITE_P(Programs, Inspect, testing::Values(meld::Program{"gradient"}), program_name);

}  // namespace
}  // namespace meld::inspect
