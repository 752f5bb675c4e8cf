// Going back and forward in a run: whatever way a tick is reached, its state is the one that it had first.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <vector>

#include "memory_shares.h"
#include "run_fixture.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/results/record/state_digest.h"
#include "runtime/results/timeline/timeline.h"

namespace meld {
namespace {

using timeline::Timeline;
using timeline::TimelineOptions;
using Digests = std::map<std::int64_t, Digest>;

class TimelineOf : public ProgramTest {
  protected:
    void each_process(int processes, const std::function<void(comm::Communicator&, const Timeline::Make&)>& body) const {
        comm::run_threads_as_processes(processes, [&](comm::Communicator& comm) {
            body(comm, [&] {
                return std::make_unique<sim::Simulation>(*static_cast<const ModuleInfo*>(module_->table()), world_, *target_, comm, 1);
            });
        });
    }
    // Of a run that nobody disturbs, after every tick.
    Digests undisturbed() const {
        Digests digests;
        each_process(1, [&](comm::Communicator&, const Timeline::Make& make) {
            const auto simulation = make();
            ASSERT_TRUE(simulation->start(registry_));
            digests[0] = record::state_digest(simulation->subdomain());
            ASSERT_TRUE(simulation->run({GetParam().ticks},
                                        [&] { digests[simulation->subdomain().tick()] = record::state_digest(simulation->subdomain()); }));
        });
        return digests;
    }

    const sim::Registry registry_ = sim::Registry::standard();
};

TEST_P(TimelineOf, GivesEveryTickAgain) {
    const Digests expected = undisturbed();
    const std::int64_t last = expected.rbegin()->first;
    ASSERT_GT(last, 3);
    for (const int processes : {1, 2, 3})
        each_process(processes, [&](comm::Communicator&, const Timeline::Make& make) {
            // So little memory that snapshots are dropped, and so often that there are some to drop.
            const std::size_t bytes = processes == 1 ? 200'000 : std::size_t{1} << 30;
            Timeline run(make, registry_, {.limits = {GetParam().ticks}, .history_bytes = bytes, .most_ticks_between = 7});
            ASSERT_TRUE(run.start());
            const auto stands_at = [&](std::int64_t tick) {
                EXPECT_EQ(run.tick(), tick);
                EXPECT_EQ(record::state_digest(run.simulation().subdomain()), expected.at(tick)) << "tick " << tick;
            };
            stands_at(0);
            // Beyond the end it stays at the end.
            ASSERT_TRUE(run.to(last + 5));
            stands_at(last);
            EXPECT_TRUE(run.ended());
            for (const std::int64_t tick : {last - 1, last / 2, std::int64_t{1}, last / 3, std::int64_t{0}, last * 3 / 4, last}) {
                SCOPED_TRACE(fmt::format("{} processes", processes));
                const auto done = run.to(tick);
                ASSERT_TRUE(done) << done.error().message();
                stands_at(tick);
                EXPECT_EQ(run.digest(tick), expected.at(tick));
            }
            for (int i = 0; i < 3; ++i) {
                ASSERT_TRUE(run.back());
                stands_at(last - i - 1);
            }
            const auto beside = run.beside(last / 2);
            ASSERT_TRUE(beside) << beside.error().message();
            EXPECT_EQ(record::state_digest((*beside)->subdomain()), expected.at(last / 2));
            stands_at(last - 3);
            ASSERT_TRUE(run.forward(3));
            stands_at(last);
            const auto too_early = run.to(-1);
            ASSERT_FALSE(too_early);
            EXPECT_THAT(too_early.error().problem, testing::HasSubstr("tick -1 is before the first, 0"));
        });
}

TEST_P(TimelineOf, CallsForEachTickAndOnceForEachNewOne) {
    // Without snapshots all ways back are from the start; with one of every tick none has to be run again.
    for (const std::size_t history : {std::size_t{0}, std::size_t{1} << 30})
        each_process(2, [&](comm::Communicator&, const Timeline::Make& make) {
            Timeline run(make, registry_, {.limits = {GetParam().ticks}, .history_bytes = history, .most_ticks_between = 1});
            ASSERT_TRUE(run.start());
            int all = 0;
            std::vector<std::int64_t> fresh;
            run.each([&](sim::Simulation&) { ++all; });
            run.each_new([&](sim::Simulation& simulation) -> Result<void> {
                fresh.push_back(simulation.subdomain().tick());
                return {};
            });
            ASSERT_TRUE(run.to(3));
            ASSERT_TRUE(run.to(1));
            ASSERT_TRUE(run.to(2));
            ASSERT_TRUE(run.to(4));
            EXPECT_EQ(all, history == 0 ? 3 + 1 + 1 + 2 : 3 + 1);
            EXPECT_EQ(fresh, (std::vector<std::int64_t>{1, 2, 3, 4}));
            // Its errors are those of the way.
            run.each_new([](sim::Simulation&) -> Result<void> { return fail("enough"); });
            const auto done = run.to(6);
            ASSERT_FALSE(done);
            EXPECT_EQ(done.error().problem, "enough");
            EXPECT_EQ(run.tick(), 4);
        });
}

TEST_P(TimelineOf, StopsBetweenTwoTicksAndGoesOn) {
    const Digests expected = undisturbed();
    each_process(3, [&](comm::Communicator& comm, const Timeline::Make& make) {
        Timeline run(make, registry_, {.limits = {GetParam().ticks}});
        ASSERT_TRUE(run.start());
        // One process is asked, and all stop.
        run.each([&](sim::Simulation& simulation) {
            if (simulation.subdomain().tick() == 1 && comm.process() == 1) simulation.subdomain().request_stop();
        });
        ASSERT_TRUE(run.to(GetParam().ticks));
        EXPECT_EQ(run.tick(), 2);
        EXPECT_EQ(run.ended(), sim::Ending::Interrupted);
        run.each({});
        ASSERT_TRUE(run.to(4));
        EXPECT_EQ(run.tick(), 4);
        EXPECT_EQ(run.digest(4), expected.at(4));
    });
}

TEST_P(TimelineOf, KeepsNoSnapshotsWithoutMemory) {
    const Digests expected = undisturbed();
    each_process(2, [&](comm::Communicator&, const Timeline::Make& make) {
        Timeline run(make, registry_, {.limits = {GetParam().ticks}, .history_bytes = 0});
        ASSERT_TRUE(run.start());
        for (const std::int64_t tick : {4, 2, 3}) {
            ASSERT_TRUE(run.to(tick));
            EXPECT_EQ(run.digest(tick), expected.at(tick));
        }
        EXPECT_TRUE(run.history().ticks().empty());
        EXPECT_EQ(run.history().bytes(), 0U);
    });
}

TEST_P(TimelineOf, BeginsAtASnapshot) {
    const Digests expected = undisturbed();
    const std::int64_t last = expected.rbegin()->first, middle = last / 2;
    sim::MemoryShares snapshot(1);
    each_process(1, [&](comm::Communicator& comm, const Timeline::Make& make) {
        Timeline run(make, registry_, {.limits = {GetParam().ticks}});
        ASSERT_TRUE(run.start());
        ASSERT_TRUE(run.to(middle));
        ASSERT_TRUE(run.simulation().save(run.simulation().counters().view(), snapshot.of(comm.process())));
    });
    each_process(2, [&](comm::Communicator&, const Timeline::Make& make) {
        Timeline run(make, registry_, {.limits = {GetParam().ticks}, .check = TimelineOptions::Check::EveryTick});
        ASSERT_TRUE(run.start(&snapshot));
        EXPECT_EQ(run.first_tick(), middle);
        ASSERT_TRUE(run.to(last));
        for (std::int64_t tick = middle; tick <= last; ++tick) EXPECT_EQ(run.digest(tick), expected.at(tick)) << "tick " << tick;
        ASSERT_TRUE(run.to(middle));
        EXPECT_EQ(record::state_digest(run.simulation().subdomain()), expected.at(middle));
        EXPECT_FALSE(run.to(middle - 1));
    });
}

INSTANTIATE_TEST_SUITE_P(Programs, TimelineOf,
                         testing::Values(Program{"gradient"}, Program{"heat", 30}, Program{"walk"}, Program{"thermometer"},
                                         Program{"mutual_exclusion"}, Program{"shape_change", 25}, Program{kOwn + "waiting"},
                                         Program{kOwn + "storm", 40}, Program{kOwn + "doze", 40}, Program{kOwn + "tumble", 30}),
                         program_name);

class FailingTimeline : public TimelineOf {};

TEST_P(FailingTimeline, StaysWhereItWas) {
    for (const int processes : {1, 3})
        each_process(processes, [&](comm::Communicator&, const Timeline::Make& make) {
            Timeline run(make, registry_, {.most_ticks_between = 2});
            ASSERT_TRUE(run.start());
            const Digest first = *run.digest(0);
            std::int64_t last = 0;  // The last tick that was begun.
            run.each([&](sim::Simulation& simulation) { last = simulation.subdomain().tick() + 1; });
            const auto done = run.to(1000);
            ASSERT_FALSE(done);
            EXPECT_THAT(done.error().problem, testing::HasSubstr("divided by zero"));
            const std::int64_t failing = last;
            ASSERT_GT(failing, 3);
            EXPECT_EQ(run.tick(), 0);
            EXPECT_EQ(record::state_digest(run.simulation().subdomain()), first);
            // The tick that fails is not tried again.
            const auto again = run.to(1000);
            ASSERT_FALSE(again);
            EXPECT_EQ(again.error().message(), done.error().message());
            EXPECT_EQ(last, failing - 1);
            EXPECT_EQ(run.tick(), 0);
            // All before it can be seen, and it stays there.
            for (const std::int64_t tick : {std::int64_t{1}, failing / 2, failing - 1}) {
                ASSERT_TRUE(run.to(tick));
                ASSERT_FALSE(run.to(failing + 3));
                EXPECT_EQ(run.tick(), tick);
                EXPECT_EQ(record::state_digest(run.simulation().subdomain()), *run.digest(tick)) << "tick " << tick;
            }
            const Digest before = *run.digest(failing - 1);
            ASSERT_TRUE(run.back(2));
            ASSERT_TRUE(run.forward(2));
            EXPECT_EQ(record::state_digest(run.simulation().subdomain()), before);
        });
}

// It is the tick itself that leaves something half done, and not the way there.
TEST_P(FailingTimeline, ComesBackFromTheMiddleOfATick) {
    each_process(2, [&](comm::Communicator&, const Timeline::Make& make) {
        Timeline run(make, registry_);
        ASSERT_TRUE(run.start());
        Result<void> done;
        while ((done = run.forward()) && run.tick() < 1000) {
        }
        ASSERT_FALSE(done);
        const Digest before = *run.digest(run.tick());
        EXPECT_EQ(record::state_digest(run.simulation().subdomain()), before);
        EXPECT_EQ(run.simulation().subdomain().status().last_tick(), run.tick());
    });
}

INSTANTIATE_TEST_SUITE_P(Programs, FailingTimeline, testing::Values(Program{kOwn + "fails"}), program_name);

// Each process saves a text of its own for a tick; chunks that do not change are alike.
class HistoryOf : public testing::Test {
  protected:
    static Result<void> save(sim::ShareSink& sink, int changing) {
        for (int i = 0; i < 10; ++i)
            if (auto done = sink.chunk({sim::Block(1000, std::byte(i)), sim::Block(1000, std::byte(i == 3 ? changing : i))}); !done)
                return done;
        return sink.rest(sim::Block(10));
    }
};

TEST_F(HistoryOf, SharesWhatHasNotChanged) {
    const auto comm = comm::make_single();
    timeline::History history(1'000'000);
    for (int tick = 0; tick < 5; ++tick) ASSERT_TRUE(history.keep(tick, [&](sim::ShareSink& s) { return save(s, tick); }, *comm));
    EXPECT_EQ(history.bytes(), 20'010 + 4 * 1'010);
    const auto first = timeline::GatheredShares::gather(*history.before(0)->second, *comm);
    const auto last = timeline::GatheredShares::gather(*history.before(9)->second, *comm);
    sim::Block room;
    const auto filled_with = [](int value) { return testing::AllOf(testing::SizeIs(1000), testing::Each(std::byte(value))); };
    EXPECT_THAT(*first.state(0, 3, room), filled_with(0));
    EXPECT_THAT(*last.state(0, 3, room), filled_with(4));
    EXPECT_THAT(*last.places(0, 9, room), filled_with(9));
}

TEST_F(HistoryOf, StaysWithinItsMemoryAndKeepsRecentTicksDense) {
    const auto comm = comm::make_single();
    const std::size_t most = 20'010 + 12 * 1'010;
    timeline::History history(most);
    for (int tick = 1; tick <= 1000; ++tick) {
        ASSERT_TRUE(history.keep(tick, [&](sim::ShareSink& s) { return save(s, tick % 256); }, *comm));
        ASSERT_LE(history.bytes(), most);
    }
    const std::vector<std::int64_t> ticks = history.ticks();
    ASSERT_GE(ticks.size(), 10U);
    EXPECT_EQ(ticks.back(), 1000);
    // The distance to the next is never much more than the age.
    for (std::size_t i = 0; i + 1 < ticks.size(); ++i) EXPECT_LE(ticks[i + 1] - ticks[i], 1000 - ticks[i]) << ticks[i];
    EXPECT_LE(1000 - ticks[ticks.size() - 4], 16);
    EXPECT_LT(ticks.front(), 800);
}

TEST_F(HistoryOf, ForgetsNothingThatItStillNeeds) {
    const auto comm = comm::make_single();
    timeline::History history(1);
    for (int tick = 0; tick < 5; ++tick) ASSERT_TRUE(history.keep(tick, [&](sim::ShareSink& s) { return save(s, 7); }, *comm));
    EXPECT_EQ(history.ticks(), std::vector<std::int64_t>{4});
    EXPECT_EQ(history.bytes(), 20'010U);
}

}  // namespace
}  // namespace meld
