// A run that goes on from a snapshot is the run that was never stopped: the same facts after every tick and the same work, on any
// number of processes and threads, from any tick.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "changed_share.h"
#include "memory_shares.h"
#include "run_fixture.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/engine/tuple/program_actions.h"
#include "runtime/module/abi/actions.h"
#include "runtime/results/record/digest_file.h"
#include "runtime/results/record/state_digest.h"
#include "runtime/sim/simulation.h"

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
        const Digest digest = running_.of(subdomain);
        if (const Result<void> same = running_.check(subdomain); !same) return same;
        const sim::Totals& all = subdomain.totals;
        const eval::Statistics& t = all.tick;
        if (subdomain.comm.process() == 0)
            ticks_[subdomain.tick()] = {digest,    t.awake,     t.derivations, t.changes,    t.messages,
                                        t.dropped, all.actions, all.catoms,    all.undefined};
        return {};
    }

  private:
    record::RunningDigest running_;
    Ticks& ticks_;
};

class Snapshot : public ProgramTest {
  protected:
    // Engines for comparison run on one process, and one of them is exact with one thread only.
    bool only_alone() const { return connects() || (world_.is_free() && world_.physics.engine != "blocks"); }
    // Connected catoms go on on several processes in random worlds (tests/programs/tumbling/composites_test.py); these are long runs of
    // few blocks.
    bool connects() const { return tuple::ProgramActions(*static_cast<const ModuleInfo*>(module_->table())).uses(ActionKind::Connect); }

    // Where bodies go from one process to another, some catoms are evaluated once more, and the run says so.
    bool counts_crossings(int processes) const { return world_.is_free() && processes > 1; }
    static Ticks without_evaluations(Ticks ticks) {
        for (auto& [tick, each] : ticks) each.evaluations = each.derivations = 0;
        return ticks;
    }
    void compare(const Ticks& ticks, const Ticks& wanted, bool crossings) const {
        if (crossings)
            EXPECT_EQ(without_evaluations(ticks), without_evaluations(wanted));
        else
            EXPECT_EQ(ticks, wanted);
    }

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
            std::optional<sim::ChangedShares> by_changes;
            if (!world_.is_free()) by_changes.emplace(simulation.subdomain());
            const ByteWriter counters;
            const auto save = [&](sim::ShareSink& sink, sim::ChangedChunks* changed) {
                return changed != nullptr ? simulation.save_changes(counters.view(), sink, *changed)
                                          : simulation.save(counters.view(), sink);
            };
            const Result<void> ran = simulation.run({GetParam().ticks}, [&] {
                // Now and then, so that much or little has changed.
                if (by_changes && simulation.subdomain().tick() % 7 < 3) {
                    EXPECT_EQ(by_changes->take(save), "");
                }
                const auto taken = into.find(simulation.subdomain().tick());
                if (taken == into.end()) return;
                const Result<void> saved = simulation.save(simulation.counters().view(), taken->second.of(comm.process()));
                ASSERT_TRUE(saved.has_value()) << saved.error().message();
            });
            ASSERT_TRUE(ran.has_value()) << ran.error().message();
            if (comm.process() != 0) return;
            const sim::Summary& s = simulation.summary();
            last_words += fmt::format("{} {} {} {} {} {} {}\n{}\n{}\n", static_cast<int>(s.ending), s.ticks, s.catoms, s.changes,
                                      s.messages, s.dropped, GetParam().name, s.undefined, fmt::join(s.outcomes, "\n"));
            last_words += fmt::format("{} {}\n", s.dead_routes.count, s.dead_routes.first);
            for (const sim::Refused& each : s.refused)
                last_words += fmt::format("{} {} {}\n", info(each.action).word, name_of(each.why), each.count);
            if (world_.is_free()) last_words = std::regex_replace(last_words, std::regex("; [0-9]+ (migrations|times space)[^;\n]*"), "");
            if (!world_.is_free()) last_words += fmt::format("{} evaluations, {} derivations\n", s.evaluations, s.derivations);
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
    std::vector<std::pair<int, int>> settings = {{2, 1}, {1, 1}, {4, 2}, {3, 1}};
    std::vector<int> saved_by = {1, 3};
    if (only_alone()) settings = {{1, 1}}, saved_by = {1};
    if (connects()) settings.emplace_back(1, 2);
    std::size_t setting = 0;
    for (const int processes : saved_by) {
        std::map<std::int64_t, sim::MemoryShares> snapshots;
        for (const std::int64_t tick : {std::int64_t{1}, last / 4, last / 2, last * 3 / 4, last - 1})
            snapshots.try_emplace(tick, static_cast<std::size_t>(processes));
        std::string words;
        const bool crossed = counts_crossings(processes);
        compare(run(processes, 1, nullptr, snapshots, words), undisturbed, crossed);
        EXPECT_EQ(words, last_words);
        for (const auto& [tick, shares] : snapshots) {
            const auto [now, threads] = settings[setting++ % settings.size()];
            SCOPED_TRACE(fmt::format("from tick {} of {} processes on {} processes of {} threads", tick, processes, now, threads));
            // It is saved again soon, to go on from what was brought back.
            const std::int64_t soon = std::min(tick + 3, last);
            const int then = only_alone() ? 1 : 5 - now;
            std::map<std::int64_t, sim::MemoryShares> again;
            again.try_emplace(soon, static_cast<std::size_t>(now));
            words.clear();
            compare(run(now, threads, &shares, again, words), Ticks(undisturbed.upper_bound(tick), undisturbed.end()),
                    crossed || counts_crossings(now));
            EXPECT_EQ(words, last_words);
            words.clear();
            compare(run(then, 1, &again.at(soon), none, words), Ticks(undisturbed.upper_bound(soon), undisturbed.end()),
                    crossed || counts_crossings(now) || counts_crossings(then));
            EXPECT_EQ(words, last_words);
            if (HasFailure()) return;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(
    Programs, Snapshot,
    testing::Values(Program{"gradient"}, Program{"flood"}, Program{"leader"}, Program{"heat", 30}, Program{"walk"}, Program{"thermometer"},
                    Program{"thermometer", 30, "thermometer", "drift"}, Program{"thermometer", 30, "thermometer", "weather"},
                    Program{"life", 30}, Program{"shortest_paths"}, Program{"mutual_exclusion"}, Program{"belief_propagation", 20},
                    Program{"shape_change", 80}, Program{kOwn + "waiting"}, Program{kOwn + "storm", 40},
                    Program{.name = kOwn + "late", .program = kGradient}, Program{.name = kOwn + "lost", .program = kGradient},
                    Program{.name = kOwn + "web", .program = kGradient}, Program{"bridge", 10}, Program{"swarm", 30},
                    Program{kOwn + "doze", 36}, Program{kOwn + "tumble", 40},
                    Program{.name = kOwn + "heap", .ticks = 28, .program = kCrowd},
                    Program{.name = kOwn + "heap", .ticks = 8, .program = kCrowd, .solver = "pgs20"},
                    Program{.name = kOwn + "heap", .ticks = 40, .program = kCrowd, .engine = "hash"},
                    Program{.name = kOwn + "heap", .ticks = 40, .program = kCrowd, .engine = "ode"},
                    Program{.name = kOwn + "pair", .ticks = 8, .program = kCrowd},
                    Program{.name = kOwn + "pair", .ticks = 8, .program = kCrowd, .engine = "hash"},
                    Program{.name = kOwn + "pair", .ticks = 8, .program = kCrowd, .engine = "ode"}, Program{"cantilever", 220}),
    program_name);

// What a run has written stays as it is if the run cannot go on.
class Refused : public ProgramTest {
  protected:
    // Refuses to go on, after all modules before it have loaded what they kept.
    class Refuses : public sim::SimModule {
      public:
        Result<void> saveable() const override { return {}; }
        Result<void> load_rest(sim::Subdomain&, ByteReader&) override { return fail("this module refuses"); }
    };
    class Agrees : public Refuses {
      public:
        Result<void> load_rest(sim::Subdomain&, ByteReader&) override { return {}; }
    };

    void TearDown() override { std::filesystem::remove(path_); }
    std::string text() const {
        std::ifstream in(path_, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    // From the start or from a snapshot; takes a snapshot in the middle. Returns whether it could go on.
    template <class Last>
    bool run(const sim::Shares* from, sim::MemoryShares* into) const {
        const auto comm = comm::make_single();
        sim::Simulation simulation(*static_cast<const ModuleInfo*>(module_->table()), world_, *target_, *comm, 1);
        std::optional<OutputFile> file;
        if (from == nullptr) file.emplace(OutputFile::open(path_, Appears::AtOnce).value());
        simulation.add(std::make_unique<record::DigestFile>(path_, Durability::Process, std::move(file)));
        simulation.add(std::make_unique<Last>());
        const Result<void> begun =
            from == nullptr ? simulation.start(sim::Registry::standard()) : simulation.resume(sim::Registry::standard(), *from);
        if (!begun) return false;
        const Result<void> ran = simulation.run({GetParam().ticks}, [&] {
            if (into == nullptr || 2 * simulation.subdomain().tick() != GetParam().ticks) return;
            EXPECT_TRUE(simulation.save(simulation.counters().view(), into->of(0)));
        });
        EXPECT_TRUE(ran.has_value());
        return true;
    }

    const std::string path_ = testing::TempDir() + "claymeld-refused-" + std::to_string(getpid());
};

TEST_P(Refused, ChangesNoDigests) {
    sim::MemoryShares snapshot(1);
    ASSERT_TRUE(run<Agrees>(nullptr, &snapshot));
    const std::string written = text();
    EXPECT_EQ(std::count(written.begin(), written.end(), '\n'), GetParam().ticks);
    EXPECT_FALSE(run<Refuses>(&snapshot, nullptr));
    EXPECT_EQ(text(), written);
    EXPECT_TRUE(run<Agrees>(&snapshot, nullptr));
    EXPECT_EQ(text(), written);
}

INSTANTIATE_TEST_SUITE_P(Programs, Refused, testing::Values(Program{"heat", 6}), program_name);

}  // namespace
}  // namespace meld
