// A set that grows in rounds holds each row once, in whatever order and number rows are proposed, and ends in order.
#include "runtime/module/kernel/rounds.h"

#include <algorithm>
#include <random>
#include <set>
#include <vector>

#include "tests/unit/runtime_module_kernel/scratch.h"

namespace meld {
namespace {

struct Pair {
    struct Row {
        i64 a1, a2;
        bool operator<(const Row& other) const { return a1 != other.a1 ? a1 < other.a1 : a2 < other.a2; }
    };
    static constexpr Reduce kReduce = Reduce::Set;
    static constexpr bool kRanked = false, kLinks = false, kKeyed = true, kWaits = false, kGrows = false;
    static int key(const Row& a, const Row& b) { return a < b ? -1 : b < a ? 1 : 0; }
    static bool same(const Row&, const Row&) { return true; }
    static u64 hash(const Row& row) { return mix(mix(0, static_cast<u64>(row.a1)), static_cast<u64>(row.a2)); }
};

using GrowingSets = ScratchTest;

TEST_F(GrowingSets, AreThoseOfASimpleSet) {
    std::mt19937_64 random{11};
    for (const u64 values : {2u, 3u, 40u, 300u}) {
        Relation<Pair> relation{};
        relation.open(nullptr, 0, 0);
        Rounds<Pair> rounds;
        rounds.start(relation);
        std::set<Pair::Row> expected;
        for (const int proposals : {1, 5, 20, 5000, 20000, 0}) {
            const std::set<Pair::Row> before = expected;
            for (int i = 0; i < proposals; ++i) {
                const Pair::Row row = {static_cast<i64>(random() % values), static_cast<i64>(random() % values)};
                rounds.propose(e, row);
                expected.insert(row);
            }
            EXPECT_EQ(rounds.end_round(e, relation), expected.size() > before.size());
            ASSERT_EQ(relation.count, expected.size());
            EXPECT_EQ(rounds.last, before.size());
            for (u32 i = 0; i < relation.count; ++i) {
                EXPECT_TRUE(expected.contains(relation.rows[i]));
                EXPECT_EQ(before.contains(relation.rows[i]), i < rounds.last);
            }
        }
        EXPECT_TRUE(rounds.finish(e, relation, nullptr, 0));
        ASSERT_EQ(relation.count, expected.size());
        u32 i = 0;
        for (const Pair::Row& row : expected) EXPECT_EQ(Pair::key(relation.rows[i++], row), 0);
    }
}

// Rows are there once while the set grows, and twice while it is sorted.
TEST_F(GrowingSets, TakeMemoryForTheirRowsAndATableOfThem) {
    constexpr u64 kSmall = 1'000;
    for (const bool none : {false, true})
        for (const u64 rows : {kSmall, 20 * kSmall, 300 * kSmall}) {
            none_left = none;
            reserved.clear();
            blocks.clear();
            e.arena = e.arena_start = e.arena_end = nullptr;
            most_reserved_bytes = 0;
            view.max_facts = rows;
            Relation<Pair> relation{};
            relation.open(nullptr, 0, 0);
            Rounds<Pair> rounds;
            rounds.start(relation);
            // Each a few times, the last ones first, in rounds of a tenth.
            for (u64 part = 10; part-- > 0;) {
                for (int again = 0; again < 3; ++again)
                    for (u64 i = rows / 10; i-- > 0;) rounds.propose(e, {static_cast<i64>(part), static_cast<i64>(i)});
                rounds.end_round(e, relation);
                EXPECT_EQ(relation.count, (10 - part) * (rows / 10));
                EXPECT_EQ(relation.rows[0].a1, 9);
            }
            EXPECT_TRUE(rounds.finish(e, relation, nullptr, 0));
            ASSERT_EQ(relation.count, rows);
            for (u64 i = 0; i < rows; ++i) {
                ASSERT_EQ(relation.rows[i].a1, static_cast<i64>(i / (rows / 10)));
                ASSERT_EQ(relation.rows[i].a2, static_cast<i64>(i % (rows / 10)));
            }
            const u64 bytes = rows * sizeof(Pair::Row);
            // Room for twice the limit, of which half is written to, and what it is sorted into, or up to 8 slots of a row. One is left.
            EXPECT_LE(most_reserved_bytes, 2 * bytes + std::max(bytes, 32 * rows));
            EXPECT_LE(reserved.size(), 1u);
            EXPECT_EQ(reserved.empty(), none || bytes < kReserved_bytes);
        }
}

TEST_F(GrowingSets, EndUnchangedIfTheSameRowsFollow) {
    const Pair::Row before[] = {{1, 2}, {3, 4}};
    Relation<Pair> relation{};
    relation.open(before, 2, 0);
    Rounds<Pair> rounds;
    rounds.start(relation);
    rounds.propose(e, {3, 4});
    rounds.propose(e, {1, 2});
    rounds.end_round(e, relation);
    EXPECT_FALSE(rounds.finish(e, relation, before, 2));
    EXPECT_EQ(relation.rows, before);
}

TEST_F(GrowingSets, AnIndexGrowsWithThem) {
    struct BySecond {
        using Row = Pair::Row;
        static u64 hash(const Row& row) { return static_cast<u64>(row.a2); }
    };
    std::mt19937_64 random{5};
    std::vector<Pair::Row> rows;
    Index<BySecond> index;
    for (int step = 0; step < 200; ++step) {
        for (int i = 0; i < 7; ++i) rows.push_back({static_cast<i64>(random() % 50), static_cast<i64>(random() % 10)});
        const u32 count = static_cast<u32>(rows.size());
        const i64 x = static_cast<i64>(random() % 11);
        const Found found = index.find_among_more(e, rows.data(), count, {0, x});
        u32 got = 0;
        for (u32 k = found.first; k < count; k = found.after(k)) got += rows[k].a2 == x;
        EXPECT_EQ(got, std::ranges::count_if(rows, [&](const Pair::Row& r) { return r.a2 == x; }));
    }
}

}  // namespace
}  // namespace meld
