// A set that grows in rounds holds each row once, in whatever order and number rows are proposed, and ends in order.
#include "runtime/module/kernel/rounds.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
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

// The same, sorted by counting digits of its words.
struct Counted : Pair {
    static constexpr u32 kWords = 2;
    static u64 word(const Row& row, u32 w) {
        return static_cast<u64>(w == 0 ? row.a1 : row.a2) ^ u64 { 1 } << 63;
    }
};

using GrowingSets = ScratchTest;

TEST_F(GrowingSets, AreSortedByCountingDigits) {
    constexpr i64 kLeast = INT64_MIN, kMost = INT64_MAX;
    std::mt19937_64 random{12};
    const auto from = [&](i64 low, u64 values) {
        return static_cast<i64>(static_cast<u64>(low) + (values == 0 ? random() : random() % values));
    };
    // Ranges of 0 to 64 bits, at the ends and across 0; two of 64 bits have too many digits.
    for (const auto& [low1, values1, low2, values2] : {std::array<i64, 4>{5, 1, kLeast, 9000},
                                                       {-700, 1400, -1, 2000},
                                                       {kMost - 4999, 5000, 3, 1},
                                                       {-3, 6, kLeast, 0},
                                                       {kLeast, 0, kLeast, 0},
                                                       {0, 1 << 22, 0, i64{1} << 33},
                                                       {-2048, 2048, -2048, 2049}}) {
        Relation<Counted> relation{};
        relation.open(nullptr, 0, 0);
        Rounds<Counted> rounds;
        rounds.start(relation);
        std::set<Pair::Row> expected;
        for (int i = 0; i < 9000; ++i) {
            const Pair::Row row = {from(low1, static_cast<u64>(values1)), from(low2, static_cast<u64>(values2))};
            rounds.propose(e, row);
            expected.insert(row);
        }
        rounds.end_round(e, relation);
        EXPECT_TRUE(rounds.finish(e, relation, nullptr, 0));
        ASSERT_EQ(relation.count, expected.size());
        EXPECT_GE(relation.count, kCountedRows);
        u32 i = 0;
        for (const Pair::Row& row : expected) ASSERT_EQ(Pair::key(relation.rows[i++], row), 0) << i << " of " << low1 << " and " << low2;
    }
}

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

// With few rows, and with a table of them.
TEST_F(GrowingSets, FindTheRowsOfTheRoundsBefore) {
    for (const i64 rows : {1, 7, 8, 9, 100, 20000}) {
        Relation<Pair> relation{};
        relation.open(nullptr, 0, 0);
        Rounds<Pair> rounds;
        rounds.start(relation);
        EXPECT_EQ(rounds.find(relation, {0, 1}), relation.count);
        for (i64 i = 0; i < rows; ++i) rounds.propose(e, {i, i * i});
        rounds.end_round(e, relation);
        for (i64 i = 0; i < rows; ++i) rounds.propose(e, {i, -i - 1});
        for (i64 i = 0; i < rows; ++i) {
            const u32 at = rounds.find(relation, {i, i * i});
            ASSERT_LT(at, relation.count);
            EXPECT_EQ(Pair::key(relation.rows[at], {i, i * i}), 0);
            // Of this round, and of none.
            EXPECT_EQ(rounds.find(relation, {i, -i - 1}), relation.count);
            EXPECT_EQ(rounds.find(relation, {i, rows * rows}), relation.count);
        }
        rounds.end_round(e, relation);
        for (i64 i = 0; i < rows; ++i) EXPECT_LT(rounds.find(relation, {i, -i - 1}), relation.count);
        rounds.finish(e, relation, nullptr, 0);
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
            EXPECT_EQ(reserved.empty(), none || std::bit_ceil(bytes) < kReserved_bytes);
        }
}

// As where linear rules fire, and the views follow anew each time.
TEST_F(GrowingSets, KeepNoRowsOfEarlierEvaluations) {
    constexpr i64 kRows = 70'000;
    Relation<Pair> relation{};
    relation.open(nullptr, 0, 0);
    Rounds<Pair> rounds;
    std::set<const Pair::Row*> places;
    for (int evaluation = 0; evaluation < 10; ++evaluation) {
        const Pair::Row* const before = relation.rows;
        const u32 before_count = relation.count;
        // Every other time the same follows again.
        const i64 offset = evaluation / 2;
        rounds.start(relation);
        for (i64 i = 0; i < kRows; ++i) rounds.propose(e, {(i + offset) * 7919 % kRows + offset, 0});
        rounds.end_round(e, relation);
        EXPECT_EQ(rounds.finish(e, relation, before, before_count), evaluation % 2 == 0);
        EXPECT_EQ(relation.rows == before, evaluation % 2 == 1);
        // An index goes by the place: none is there again with other rows.
        EXPECT_EQ(places.insert(relation.rows).second, evaluation % 2 == 0);
        for (u32 i = 0; i < relation.count; ++i) ASSERT_EQ(relation.rows[i].a1, i + offset);
        u64 bytes = 0;
        for (const auto& [_, one] : reserved) bytes += one.second;
        EXPECT_LE(bytes, 2 * 1'000'000 * sizeof(Pair::Row));
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
