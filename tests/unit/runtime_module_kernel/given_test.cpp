// Persistent facts that are given one by one, in whatever order, are a sorted set; what they take is proportional to their number.
#include <algorithm>
#include <numeric>
#include <random>
#include <set>
#include <vector>

#include "runtime/module/kernel/bags.h"
#include "tests/unit/runtime_module_kernel/scratch.h"

namespace meld {
namespace {

struct Number {
    struct Row {
        i64 a1;
    };
    static constexpr Reduce kReduce = Reduce::Set;
    static constexpr bool kRanked = false, kLinks = false, kKeyed = true, kWaits = false, kGrows = false;
    static int key(const Row& a, const Row& b) { return a.a1 < b.a1 ? -1 : b.a1 < a.a1 ? 1 : 0; }
    static bool same(const Row&, const Row&) { return true; }
};

class GivenFacts : public ScratchTest {
  protected:
    // Scratch memory is one chunk.
    void SetUp() override {
        chunk.resize(std::size_t{64} << 20);
        e.arena = e.arena_start = chunk.data();
        e.arena_end = chunk.data() + chunk.size();
    }
    std::vector<u8> chunk;
};

TEST_F(GivenFacts, AreASortedSet) {
    std::mt19937_64 random{3};
    for (const int stored : {0, 1, 7}) {
        std::vector<Number::Row> column;
        for (int i = 0; i < stored; ++i) column.push_back({20 * i});
        const std::vector<Number::Row> untouched = column;
        Relation<Number> relation{};
        relation.open(column.data(), static_cast<u32>(column.size()), 0);
        std::set<i64> expected;
        for (const Number::Row& row : column) expected.insert(row.a1);
        for (int i = 0; i < 400; ++i) {
            const i64 value = static_cast<i64>(random() % 150);
            EXPECT_EQ(give_base(e, relation, {value}), expected.insert(value).second);
            ASSERT_EQ(relation.count, expected.size());
            u32 at = 0;
            for (const i64 v : expected) ASSERT_EQ(relation.rows[at++].a1, v);
        }
        EXPECT_TRUE(relation.changed);
        // What the column has stays.
        EXPECT_TRUE(std::ranges::equal(column, untouched, {}, &Number::Row::a1, &Number::Row::a1));
        EXPECT_EQ(relation.origin, column.data());
    }
}

TEST_F(GivenFacts, TakeMemoryInProportion) {
    for (const i64 count : {100, 1'000, 10'000, 100'000})
        for (const i64 step : {i64{1}, i64{-1}, i64{7}}) {
            e.arena = e.arena_start;
            Relation<Number> relation{};
            relation.open(nullptr, 0, 0);
            // Upwards, downwards and, where they are not too many, through each other.
            if (step == 7 && count > 10'000) continue;
            for (i64 i = 0; i < count; ++i) EXPECT_TRUE(give_base(e, relation, {step < 0 ? -i : step == 1 ? i : i * 7919 % count}));
            EXPECT_EQ(relation.count, count);
            EXPECT_LE(static_cast<i64>(e.arena - e.arena_start), 8 * count * static_cast<i64>(sizeof(Number::Row)) + 256);
        }
}

}  // namespace
}  // namespace meld
