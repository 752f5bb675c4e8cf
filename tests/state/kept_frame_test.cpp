// Frames of the viewer that are kept: for which looks there are some, and that no more is looked at than has changed. That they are those
// that are made from the whole run is what tests/view/frames_test.py compares; it would go on to pass if none were kept.
#include "runtime/show/view/kept/kept_frame.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "run_fixture.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/show/view/kept/changed_catoms.h"

namespace meld {
namespace {

constexpr std::size_t kMost = 100000;

class KeptFrames : public ProgramTest {
  protected:
    // Calls body(simulation, drawing) before the first tick.
    void run(const std::function<void(sim::Simulation&, record::Drawing&)>& body) const {
        comm::run_threads_as_processes(1, [&](comm::Communicator& comm) {
            sim::Simulation simulation(*static_cast<const ModuleInfo*>(module_->table()), world_, *target_, comm, 1);
            auto follows = std::make_unique<record::Drawing>();
            record::Drawing& drawing = *follows;
            simulation.add(std::move(follows), "recorder");
            ASSERT_TRUE(simulation.start(registry_));
            body(simulation, drawing);
        });
    }

    const sim::Registry registry_ = sim::Registry::standard();
};

TEST_P(KeptFrames, AreThereForLooksAtEachCatomAlone) {
    run([](sim::Simulation& simulation, record::Drawing& drawing) {
        const auto kept = [&](const picture::Look& look) {
            return view::KeptFrame::make(simulation.subdomain(), drawing, look, kMost) != nullptr;
        };
        for (const char* const body :
             {"", "dist(A, D)", "source(A)", "dist(A, D), D > 3", "dist(A, D), not source(A)", "neighborCount(A, N)",
              "neighbor(A, B), B > A", "vacant(A, P)", "cell(A, X, _, _)", "dist(A, D), id(A, I), I > D"}) {
            EXPECT_TRUE(kept({.colour = body})) << body;
            EXPECT_TRUE(kept({.only = body})) << body;
            EXPECT_TRUE(kept({.hide = body})) << body;
        }
        // These may change although nothing has changed at the catom.
        for (const char* const body :
             {"dist(A, D), tick(A, T)", "neighbor(A, B), dist(B, D)", "dist(A, D), dist(@0, E), D > E", "nothing(A)"})
            EXPECT_FALSE(kept({.colour = body})) << body;
        EXPECT_FALSE(kept({.links = "neighbor(A, B)"}));
        EXPECT_FALSE(kept({.labels = "dist(A, D)"}));
        EXPECT_FALSE(kept({.exposed = true}));
    });
}

TEST_P(KeptFrames, LookOnlyAtWhatHasChanged) {
    run([](sim::Simulation& simulation, record::Drawing&) {
        const picture::Look look{.colour = "dist(A, D)"};
        sim::Subdomain& subdomain = simulation.subdomain();
        std::optional<view::ChangedCatoms> changed = view::ChangedCatoms::make(subdomain.module, look);
        ASSERT_TRUE(changed);
        view::CellBox box(world::LatticeKind::Cubic);
        box.grow({.low = {-32, -32, -32}, .high = {32, 32, 32}});
        sim::Touched& touched = subdomain.follow();
        const auto looked_at = [&] {
            std::size_t count = 0;
            changed->begin(subdomain, touched);
            const auto done = changed->look(
                subdomain, box, [&](const view::ShownCatoms& some) { count += some.rows.size(); }, [&](std::uint64_t) { ++count; });
            EXPECT_TRUE(done.has_value());
            return count;
        };
        EXPECT_EQ(looked_at(), subdomain.ensemble.owned_count());
        EXPECT_EQ(looked_at(), 0);
        // The wave has reached the third layer around its corner: ten catoms of 8,000 have a new distance, and six knew theirs before.
        ASSERT_TRUE(simulation.run({4}, [] {}));
        looked_at();
        ASSERT_TRUE(simulation.run({5}, [] {}));
        const std::size_t after_a_tick = looked_at();
        EXPECT_GE(after_a_tick, 10);
        EXPECT_LE(after_a_tick, 80);
    });
}

TEST_P(KeptFrames, AreOthersOnlyAfterChanges) {
    run([](sim::Simulation& simulation, record::Drawing& drawing) {
        using enum view::KeptFrame::Updated;
        const picture::Look look{.colour = "dist(A, D)"};
        sim::Subdomain& subdomain = simulation.subdomain();
        const auto frame = view::KeptFrame::make(subdomain, drawing, look, kMost);
        ASSERT_NE(frame, nullptr);
        sim::Touched& touched = subdomain.follow();
        const auto updated = [&] { return frame->update(subdomain, drawing, touched).value(); };
        EXPECT_EQ(updated(), Other);
        EXPECT_EQ(updated(), Same);
        ASSERT_TRUE(simulation.run({3}, [] {}));
        EXPECT_EQ(updated(), Other);
        ASSERT_TRUE(simulation.run({-1}, [] {}));
        EXPECT_EQ(updated(), Other);
        EXPECT_EQ(updated(), Same);
    });
}

INSTANTIATE_TEST_SUITE_P(Programs, KeptFrames, testing::Values(Program{.name = "gradient"}), program_name);

}  // namespace
}  // namespace meld
