// Work is proportional to change: what a small change costs in a large ensemble that was at rest.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <random>

#include "compiled.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/sim/core/subdomain.h"
#include "runtime/sim/core/tick.h"
#include "runtime/world/ensemble/target.h"

namespace meld::retraction {
namespace {

using world::Cell;

constexpr std::int32_t kSide = 316;
constexpr std::uint64_t kCatoms = std::uint64_t{kSide} * kSide;

struct Cost {
    std::uint64_t ticks = 0, evaluations = 0, changes = 0;
};

// A quiescent gradient from the first corner of a square, on one process.
class Locality : public testing::Test {
  protected:
    void SetUp() override {
        Result<Module> module = compiled("hops");
        ASSERT_TRUE(module) << module.error().message();
        module_ = std::make_unique<Module>(std::move(*module));
        world_.lattice = world::LatticeKind::Square;
        for (std::int32_t y = 0; y < kSide; ++y)
            for (std::int32_t x = 0; x < kSide; ++x) world_.cells.push_back({x, y, 0});
        world::sort_cells(world_.cells, world::Lattice(world_.lattice));
        Result<world::Target> target = world::Target::make(world_, world::Lattice(world_.lattice));
        ASSERT_TRUE(target) << target.error().message();
        target_ = std::make_unique<world::Target>(std::move(*target));
        subdomain_ = std::make_unique<sim::Subdomain>(info_of(*module_), world_, *target_, *comm_, 1);
        ASSERT_TRUE(subdomain_->populate());
        tick_ = std::make_unique<sim::Tick>(*subdomain_);
        source_ = subdomain_->module.predicates[*tuple::find_predicate(subdomain_->module, "source", 0)].base;
        set_source({0, 0, 0}, true);
        settled_ = settle();
    }
    void set_source(Cell cell, bool on) {
        if (on)
            subdomain_->give(source_, *subdomain_->ensemble.at(cell), nullptr);
        else
            subdomain_->take(source_, *subdomain_->ensemble.at(cell), nullptr);
    }
    Cost settle() {
        Cost cost;
        bool busy = true;
        while (busy && cost.ticks < 10'000) {
            tick_->begin();
            const sim::Totals& totals = tick_->end();
            ++cost.ticks;
            cost.evaluations += totals.tick.awake;
            cost.changes += totals.tick.changes;
            busy = totals.awake || totals.waiting;
        }
        EXPECT_FALSE(busy) << "never quiet";
        return cost;
    }
    static void tell(const char* what, const Cost& cost, std::uint64_t times = 1) {
        std::printf("%s: %.1f ticks, %.1f evaluations, %.1f exported changes\n", what,
                    static_cast<double>(cost.ticks) / static_cast<double>(times),
                    static_cast<double>(cost.evaluations) / static_cast<double>(times),
                    static_cast<double>(cost.changes) / static_cast<double>(times));
    }

    world::World world_;
    std::unique_ptr<comm::Communicator> comm_ = comm::make_single();
    std::unique_ptr<Module> module_;
    std::unique_ptr<world::Target> target_;
    std::unique_ptr<sim::Subdomain> subdomain_;
    std::unique_ptr<sim::Tick> tick_;
    u32 source_ = 0;
    Cost settled_;
};

TEST_F(Locality, SettlingTouchesEachCatomAFewTimes) {
    tell("settling", settled_);
    EXPECT_EQ(settled_.changes, kCatoms);
    EXPECT_LE(settled_.evaluations, 4 * kCatoms);
    EXPECT_LE(settled_.ticks, 2u * kSide + 2);
}

TEST_F(Locality, LosingAndGainingACatomIsALocalMatter) {
    constexpr int kTimes = 5000;
    std::mt19937_64 random(1);
    Cost removal, return_;
    std::uint64_t worst = 0;
    const auto add = [](Cost& sum, const Cost& cost) {
        sum.ticks += cost.ticks;
        sum.evaluations += cost.evaluations;
        sum.changes += cost.changes;
    };
    for (int i = 0; i < kTimes; ++i) {
        const Cell cell{1 + static_cast<std::int32_t>(random() % (kSide - 1)), static_cast<std::int32_t>(random() % kSide), 0};
        const sim::Catom catom = *subdomain_->ensemble.at(cell);
        const std::uint64_t id = subdomain_->ensemble.id(catom);
        subdomain_->remove_catom(catom);
        subdomain_->refresh();
        const Cost cost = settle();
        worst = std::max(worst, cost.evaluations);
        add(removal, cost);
        subdomain_->mark(subdomain_->add_catom(id, cell, kCatomOwned), kDirtyBirths);
        subdomain_->refresh();
        add(return_, settle());
    }
    tell("a catom goes", removal, kTimes);
    tell("a catom comes back", return_, kTimes);
    std::printf("the worst: %llu evaluations\n", static_cast<unsigned long long>(worst));
    EXPECT_LE(removal.evaluations, 100u * kTimes);
    EXPECT_LE(return_.evaluations, 100u * kTimes);
    // Ranks do not drift upwards while the ensemble changes.
    EXPECT_LE(subdomain_->totals.greatest_rank, 2u * kSide);
}

TEST_F(Locality, FallingBackToAnotherSourceTouchesOnlyWhatHungOnTheFirst) {
    set_source({kSide - 1, kSide - 1, 0}, true);
    tell("a second source in the far corner", settle());
    set_source({0, 0, 0}, false);
    const Cost fallback = settle();
    tell("the first source goes", fallback);
    EXPECT_LE(fallback.changes, kCatoms + 1000);
    EXPECT_LE(fallback.ticks, 2u * kSide + 10);
    set_source({0, 0, 0}, true);
    const Cost restored = settle();
    tell("it comes back", restored);
    EXPECT_LE(restored.changes, kCatoms / 2 + 1000);
}

TEST_F(Locality, WithoutASourceEachValueGoesOnce) {
    set_source({0, 0, 0}, false);
    const Cost lost = settle();
    tell("the only source goes", lost);
    EXPECT_EQ(lost.changes, kCatoms);
    set_source({0, 0, 0}, true);
    const Cost restored = settle();
    tell("it comes back", restored);
    EXPECT_EQ(restored.changes, kCatoms);
}

}  // namespace
}  // namespace meld::retraction
