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
    static void set_last(Row& row, u64 word) { row.a2 = static_cast<i64>(word ^ u64{1} << 63); }
};

// Looked up by their first argument.
struct PairsByFirst {
    using Row = Pair::Row;
    static int order(const Row& a, const Row& b) { return a.a1 < b.a1 ? -1 : b.a1 < a.a1 ? 1 : 0; }
    static u64 hash(const Row& row) { return mix(0, static_cast<u64>(row.a1)); }
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
        EXPECT_FALSE(rounds.sees({0, 1}));
        for (i64 i = 0; i < rows; ++i) rounds.propose(e, {i, i * i});
        rounds.end_round(e, relation);
        for (i64 i = 0; i < rows; ++i) rounds.propose(e, {i, -i - 1});
        for (i64 i = 0; i < rows; ++i) {
            EXPECT_TRUE(rounds.sees({i, i * i}));
            // Of this round, and of none.
            EXPECT_FALSE(rounds.sees({i, -i - 1}));
            EXPECT_FALSE(rounds.sees({i, rows * rows}));
        }
        rounds.end_round(e, relation);
        for (i64 i = 0; i < rows; ++i) EXPECT_TRUE(rounds.sees({i, -i - 1}));
        rounds.finish(e, relation, nullptr, 0);
    }
}

// Those that are told apart by ints are in bitmaps while they lie close together, whichever way they grow, and stay the same set.
TEST_F(GrowingSets, OfIntsThatLieCloseTogetherHaveBitmaps) {
    constexpr i64 kLeast = INT64_MIN, kMost = INT64_MAX;
    struct Case {
        const char* name;
        i64 heads, first, per_row, values;  // The second number of row i is from `first + per_row i` on, one of so many.
        bool bitmaps;
    };
    for (const Case& c : {Case{"close together", 50, -3000, 0, 900, true}, Case{"upwards", 20, 100, 1, 500, true},
                          Case{"downwards", 20, 100, -1, 500, true}, Case{"from the least", 30, kLeast, 0, 700, true},
                          Case{"to the most", 30, kMost - 699, 0, 700, true}, Case{"each with another head", 1'000'000, 0, 0, 9000, false},
                          Case{"far apart", 50, kLeast / 2, 0, kMost, false}, Case{"ever further", 50, 0, 100'000, 10, false}}) {
        SCOPED_TRACE(c.name);
        std::mt19937_64 random{13};
        Relation<Counted> relation{};
        relation.open(nullptr, 0, 0);
        Rounds<Counted> rounds;
        rounds.start(relation);
        Index<PairsByFirst> index;
        index.reset();
        std::set<Pair::Row> expected;
        i64 row = 0;
        for (const int proposals : {3, 3000, 9000, 9000}) {
            const std::set<Pair::Row> before = expected;
            for (int i = 0; i < proposals; ++i, ++row) {
                const i64 second = c.first + c.per_row * row + static_cast<i64>(random() % static_cast<u64>(c.values));
                const Pair::Row one = {static_cast<i64>(random() % static_cast<u64>(c.heads)), second};
                rounds.propose(e, one);
                expected.insert(one);
                // What rules see does not change meanwhile, also while they go through it.
                if (i % 1000 == 1) {
                    auto among = rounds.among(e, index, relation, one);
                    std::set<Pair::Row> found;
                    for (int more = 0; among.next(); ++more) {
                        if (among.row.a1 == one.a1) EXPECT_TRUE(found.insert(among.row).second);
                        const Pair::Row next = {one.a1, second + more};
                        if (second > kMost - 20000) continue;
                        rounds.propose(e, next);
                        expected.insert(next);
                    }
                    std::set<Pair::Row> those;
                    for (const Pair::Row& r : before)
                        if (r.a1 == one.a1) those.insert(r);
                    EXPECT_TRUE(std::ranges::equal(found, those, [](const auto& a, const auto& b) { return Pair::key(a, b) == 0; }));
                    EXPECT_EQ(rounds.sees(one), before.contains(one));
                }
            }
            EXPECT_EQ(rounds.end_round(e, relation), expected.size() > before.size());
            ASSERT_EQ(relation.count, expected.size());
            for (u32 i = 0; i < relation.count; ++i) {
                EXPECT_TRUE(rounds.sees(relation.rows[i]));
                EXPECT_EQ(before.contains(relation.rows[i]), i < rounds.last);
            }
            EXPECT_FALSE(rounds.sees({-1, c.first}));
        }
        EXPECT_EQ(rounds.maps.used, c.bitmaps);
        EXPECT_TRUE(rounds.finish(e, relation, nullptr, 0));
        ASSERT_EQ(relation.count, expected.size());
        u32 i = 0;
        for (const Pair::Row& r : expected) EXPECT_EQ(Pair::key(relation.rows[i++], r), 0);
    }
}

// A set of one counter that goes up or down makes its bitmaps anew a few times for each doubling, so ten times the rows take ten times the
// memory, and a bitmap less than the table would.
TEST_F(GrowingSets, BitmapsGrowWithTheirRows) {
    for (const i64 step : {1, -1})
        for (const u64 rows : {20'000u, 200'000u, 2'000'000u}) {
            reserved.clear();
            blocks.clear();
            e.arena = e.arena_start = e.arena_end = nullptr;
            most_reserved_bytes = reservations = 0;
            view.max_facts = view.max_growing_facts = rows;
            Relation<Counted> relation{};
            relation.open(nullptr, 0, 0);
            Rounds<Counted> rounds;
            rounds.start(relation);
            for (u64 i = 0; i < rows; ++i) {
                rounds.propose(e, {5, step * static_cast<i64>(i)});
                if (i % 1000 == 0) rounds.end_round(e, relation);
            }
            rounds.end_round(e, relation);
            EXPECT_TRUE(rounds.maps.used);
            EXPECT_EQ(relation.count, rows);
            // The rows have room for twice as many as there may be.
            EXPECT_LE(most_reserved_bytes, 2 * sizeof(Pair::Row) * rows + rows * 2 + (1 << 20));
            EXPECT_LE(reservations, 40u + 4 * std::bit_width(rows));
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
