// Runs in the virtual cluster: whatever the order of turns, and wherever processes are killed and the run goes on from its last snapshot
// on another number of them, every tick has the facts that it has in a run of one process.
#include "runtime/comm/transport/cluster.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "runtime/base/random.h"
#include "runtime/results/record/state_digest.h"
#include "runtime/sim/simulation.h"
#include "tests/state/memory_shares.h"
#include "tests/state/random_division.h"
#include "tests/state/run_fixture.h"

namespace meld {
namespace {

using Digests = std::map<std::int64_t, Digest>;

// Notes the digest of each tick, and what differs from those that are known.
class Notes : public sim::SimModule {
  public:
    Notes(Digests& noted, const Digests& known) : noted_(noted), known_(known) {}
    Result<void> saveable() const override { return {}; }
    Result<void> after(sim::Subdomain& subdomain) override {
        const Digest digest = running_.of(subdomain);
        if (const Result<void> same = running_.check(subdomain); !same) return same;
        if (subdomain.comm.process() != 0) return {};
        noted_[subdomain.tick()] = digest;
        const auto known = known_.find(subdomain.tick());
        if (!known_.empty() && (known == known_.end() || known->second != digest))
            return fail(fmt::format("tick {} has other facts", subdomain.tick()));
        return {};
    }

  private:
    record::RunningDigest running_;
    Digests& noted_;
    const Digests& known_;
};

// A snapshot counts once all processes have taken it.
struct Taken {
    sim::MemoryShares shares;
    int by = 0;
};

class Cluster : public ProgramTest {
  protected:
    std::uint64_t draw(std::uint64_t below) const { return random_bits(seed_, 0x636c7573, ++draws_, 0) % below; }

    void body(comm::Communicator& comm, const sim::Shares* from, Digests& noted, std::map<std::int64_t, Taken>& taken,
              std::int64_t every) const {
        sim::Simulation simulation(*static_cast<const ModuleInfo*>(module_->table()), world_, *target_, comm, 1);
        simulation.add(std::make_unique<Notes>(noted, alone_));
        const Result<void> begun =
            from == nullptr ? simulation.start(sim::Registry::standard()) : simulation.resume(sim::Registry::standard(), *from);
        ASSERT_TRUE(begun.has_value()) << begun.error().message();
        const Result<void> ran = simulation.run({GetParam().ticks}, [&] {
            const std::int64_t tick = simulation.subdomain().tick();
            // In half of the runs catoms go to other processes all the time.
            const std::uint64_t division = random_bits(seed_, 0x64697669, static_cast<std::uint64_t>(tick), 0);
            if (seed_ % 2 == 0 && division % 3 == 0)
                simulation.divide_anew(random_division(simulation.subdomain().lattice, comm.processes(), division));
            if (every == 0 || tick % every != 0) return;
            Taken& into = taken.try_emplace(tick, Taken{sim::MemoryShares(static_cast<std::size_t>(comm.processes()))}).first->second;
            const Result<void> saved = simulation.save(simulation.counters().view(), into.shares.of(comm.process()));
            ASSERT_TRUE(saved.has_value()) << saved.error().message();
            ++into.by;
        });
        ASSERT_TRUE(ran.has_value()) << ran.error().message();
    }

    // A run that is killed some times and goes on.
    void run(std::uint64_t seed) {
        SCOPED_TRACE(fmt::format("seed {}", seed));
        seed_ = seed;
        draws_ = 0;
        Digests noted;
        std::optional<sim::MemoryShares> from;
        std::uint64_t steps = 2000;
        const auto kills = static_cast<int>(draw(4));
        for (int attempt = 0;; ++attempt) {
            comm::ClusterOptions options{.processes = 1 + static_cast<int>(draw(4)), .seed = draw(1U << 31U)};
            if (attempt < kills) options.kill_at_step = 1 + draw(steps);
            const auto every = static_cast<std::int64_t>(1 + draw(7));
            std::map<std::int64_t, Taken> taken;
            const comm::ClusterRun ran = comm::run_cluster(
                options, [&](comm::Communicator& comm) { body(comm, from ? &*from : nullptr, noted, taken, attempt < kills ? every : 0); });
            ASSERT_FALSE(HasFailure());
            ++runs_;
            turns_ += ran.steps;
            if (ran.killed < 0) break;
            ++killed_;
            steps = std::max<std::uint64_t>(ran.steps, 2000);
            while (!taken.empty() && taken.rbegin()->second.by != options.processes) taken.erase(std::prev(taken.end()));
            if (!taken.empty()) from = std::move(taken.rbegin()->second.shares);
        }
        EXPECT_EQ(noted, alone_);
    }

    Digests alone_;
    std::uint64_t seed_ = 0;
    mutable std::uint64_t draws_ = 0;
    std::uint64_t runs_ = 0, turns_ = 0, killed_ = 0;
};

TEST_P(Cluster, EveryTickIsTheSame) {
    Digests noted;
    std::map<std::int64_t, Taken> none;
    body(*comm::make_single(), nullptr, noted, none, 0);
    ASSERT_GT(noted.size(), 3U);
    alone_ = std::move(noted);
    const char* const wanted = std::getenv("CLAYMELD_CLUSTER_SEEDS");
    const std::uint64_t seeds = wanted == nullptr ? 6 : std::strtoull(wanted, nullptr, 10);
    for (std::uint64_t seed = 0; seed < seeds && !HasFailure(); ++seed) run(seed);
    fmt::print("{} seeds, {} runs, {} killed, {} turns\n", seeds, runs_, killed_, turns_);
    // Otherwise nothing was tested.
    EXPECT_GT(turns_, 100 * seeds);
}

INSTANTIATE_TEST_SUITE_P(Programs, Cluster,
                         testing::Values(Program{"gradient", 40}, Program{"walk", 30}, Program{"leader", 30},
                                         Program{"mutual_exclusion", 30}, Program{"shape_change", 30}, Program{kOwn + "storm", 30},
                                         Program{kOwn + "waiting", 30}, Program{.name = kOwn + "late", .program = kGradient},
                                         Program{.name = kOwn + "lost", .program = kGradient},
                                         Program{.name = kOwn + "web", .ticks = 30, .program = kGradient},
                                         Program{.name = kOwn + "heap", .ticks = 12, .program = kCrowd}, Program{kOwn + "tumble", 20}),
                         program_name);

}  // namespace
}  // namespace meld
