// A run that goes on from a snapshot is the run that was never stopped: the same facts after every tick and the same work, on any
// number of processes and threads, from any tick.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "run_fixture.h"
#include "runtime/comm/communicator.h"
#include "runtime/record/state_digest.h"
#include "runtime/sim/simulation.h"
#include "runtime/sim/state/memory_shares.h"

namespace meld {
namespace {

// What a tick left and what it took.
struct Tick {
    Digest facts;
    std::uint64_t evaluations = 0, derivations = 0, changes = 0, messages = 0, dropped = 0, actions = 0, catoms = 0;
    bool undefined = false;
    bool operator==(const Tick&) const = default;
};
using Ticks = std::map<std::int64_t, Tick>;

std::ostream& operator<<(std::ostream& out, const Tick& t) {
    return out << t.facts.to_string() << ", " << t.evaluations << " evaluations, " << t.derivations << " derivations, " << t.changes
               << " changes, " << t.messages << " messages, " << t.dropped << " dropped, " << t.actions << " actions, " << t.catoms
               << " catoms" << (t.undefined ? ", undefined" : "");
}

class TickNotes : public sim::SimModule {
  public:
    explicit TickNotes(Ticks& ticks) : ticks_(ticks) {}
    Result<void> saveable() const override { return {}; }
    Result<void> after(sim::Subdomain& subdomain) override {
        const Digest digest = record::state_digest(subdomain);
        const sim::Totals& all = subdomain.totals;
        const eval::Statistics& t = all.tick;
        if (subdomain.comm.process() == 0)
            ticks_[subdomain.tick()] = {digest,    t.awake,     t.derivations, t.changes,    t.messages,
                                        t.dropped, all.actions, all.catoms,    all.undefined};
        return {};
    }

  private:
    Ticks& ticks_;
};

class Snapshot : public ProgramTest {
  protected:
    // Runs from the start or from a snapshot, up to a tick, and takes snapshots after the ticks that `into` names.
    // What the run says of itself at its end is added to `last_words`.
    Ticks run(int processes, int threads, const sim::Shares* from, std::map<std::int64_t, sim::MemoryShares>& into,
              std::string& last_words) const {
        Ticks ticks;
        comm::run_threads_as_processes(processes, [&](comm::Communicator& comm) {
            sim::Simulation simulation(*static_cast<const ModuleInfo*>(module_->table()), world_, *target_, comm, threads);
            simulation.add(std::make_unique<TickNotes>(ticks));
            const Result<void> started =
                from == nullptr ? simulation.start(sim::Registry::standard()) : simulation.resume(sim::Registry::standard(), *from);
            ASSERT_TRUE(started.has_value()) << started.error().message();
            const Result<void> ran = simulation.run({GetParam().ticks}, [&] {
                const auto taken = into.find(simulation.subdomain().tick());
                if (taken == into.end()) return;
                const Result<void> saved = simulation.save(taken->second.of(comm.process()));
                ASSERT_TRUE(saved.has_value()) << saved.error().message();
            });
            ASSERT_TRUE(ran.has_value()) << ran.error().message();
            if (comm.process() != 0) return;
            const sim::Summary& s = simulation.summary();
            last_words +=
                fmt::format("{} {} {} {} {} {} {} {} {}\n{}\n{}\n", static_cast<int>(s.ending), s.ticks, s.catoms, s.evaluations,
                            s.derivations, s.changes, s.messages, s.dropped, GetParam().name, s.undefined, fmt::join(s.outcomes, "\n"));
        });
        return ticks;
    }
};

TEST_P(Snapshot, GoesOnAsIfNothingHadHappened) {
    std::map<std::int64_t, sim::MemoryShares> none;
    std::string last_words;
    const Ticks undisturbed = run(1, 1, nullptr, none, last_words);
    ASSERT_GT(undisturbed.size(), 3U);
    const auto last = static_cast<std::int64_t>(undisturbed.size());
    // Processes and threads of the run that goes on, one after the other.
    const std::vector<std::pair<int, int>> settings = {{2, 1}, {1, 1}, {4, 2}, {3, 1}};
    std::size_t setting = 0;
    for (const int processes : {1, 3}) {
        std::map<std::int64_t, sim::MemoryShares> snapshots;
        for (const std::int64_t tick : {std::int64_t{1}, last / 4, last / 2, last * 3 / 4, last - 1})
            snapshots.try_emplace(tick, static_cast<std::size_t>(processes));
        std::string words;
        EXPECT_EQ(run(processes, 1, nullptr, snapshots, words), undisturbed) << "taking snapshots changed the run";
        EXPECT_EQ(words, last_words);
        for (const auto& [tick, shares] : snapshots) {
            const auto [now, threads] = settings[setting++ % settings.size()];
            SCOPED_TRACE(fmt::format("from tick {} of {} processes on {} processes of {} threads", tick, processes, now, threads));
            // It is saved again soon, to go on from what was brought back.
            const std::int64_t soon = std::min(tick + 3, last);
            std::map<std::int64_t, sim::MemoryShares> again;
            again.try_emplace(soon, static_cast<std::size_t>(now));
            words.clear();
            EXPECT_EQ(run(now, threads, &shares, again, words), Ticks(undisturbed.upper_bound(tick), undisturbed.end()));
            EXPECT_EQ(words, last_words);
            words.clear();
            EXPECT_EQ(run(5 - now, 1, &again.at(soon), none, words), Ticks(undisturbed.upper_bound(soon), undisturbed.end()));
            EXPECT_EQ(words, last_words);
            if (HasFailure()) return;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Programs, Snapshot,
                         testing::Values(Program{"gradient"}, Program{"flood"}, Program{"leader"}, Program{"heat", 30}, Program{"walk"},
                                         Program{"thermometer"}, Program{"thermometer", 30, "thermometer", "drift"},
                                         Program{"thermometer", 30, "thermometer", "weather"}, Program{"life", 30},
                                         Program{"shortest_paths"}, Program{"mutual_exclusion"}, Program{"belief_propagation", 20},
                                         Program{"shape_change", 80}, Program{kOwn + "waiting"}, Program{kOwn + "storm", 40}),
                         program_name);

}  // namespace
}  // namespace meld
