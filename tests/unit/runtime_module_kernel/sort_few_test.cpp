// The few rows that arrive at once are sorted as a stable sort by all arguments would do it.
#include "runtime/module/kernel/sort_few.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace meld {
namespace {

template <class V>
int order(V a, V b) {
    return a < b ? -1 : b < a ? 1 : 0;
}

// fact(node, int, float)
struct Told {
    struct Row {
        i64 a1;
        double a2;
    };
    static constexpr auto kLast = &Row::a2;
    static bool alike(const Row& a, const Row& b) { return a.a1 == b.a1; }
    static int key(const Row& a, const Row& b) { return a.a1 != b.a1 ? order(a.a1, b.a1) : order(a.a2, b.a2); }
};
// A fact of one argument, of different types.
template <class V>
struct Token {
    struct Row {
        V a1;
    };
    static constexpr auto kLast = &Row::a1;
    static bool alike(const Row&, const Row&) { return true; }
    static int key(const Row& a, const Row& b) { return order(a.a1, b.a1); }
};
// Its type does not say which argument is the last.
struct Plain {
    using Row = Told::Row;
    static int key(const Row& a, const Row& b) { return Told::key(a, b); }
};

template <class T>
void expect_sorted(std::vector<typename T::Row> rows, const std::string& what) {
    using Row = typename T::Row;
    std::vector<Row> expected = rows;
    std::stable_sort(expected.begin(), expected.end(), [](const Row& a, const Row& b) { return T::key(a, b) < 0; });
    sort_few<T, true>(rows.data(), static_cast<u32>(rows.size()));
    for (std::size_t i = 0; i < rows.size(); ++i) ASSERT_EQ(T::key(rows[i], expected[i]), 0) << what << ", place " << i;
}

TEST(SortFew, MergeExchangeSortsAllZerosAndOnes) {
    const auto sorts = [](const auto& network, u32 n) {
        for (u32 bits = 0; bits < u32{1} << n; ++bits) {
            u32 now = bits;
            for (u32 i = 0; i < network.count; ++i) {
                const u32 low = now >> network.low[i] & 1, high = now >> network.high[i] & 1;
                if (low > high) now ^= u32{1} << network.low[i] | u32{1} << network.high[i];
            }
            // All ones are at the end.
            const u32 ones = static_cast<u32>(__builtin_popcount(bits));
            if (now != ((u32{1} << ones) - 1) << (n - ones)) return false;
        }
        return true;
    };
    EXPECT_TRUE(sorts(MergeExchange<2>(), 2));
    EXPECT_TRUE(sorts(MergeExchange<4>(), 4));
    EXPECT_TRUE(sorts(MergeExchange<5>(), 5));
    EXPECT_TRUE(sorts(MergeExchange<6>(), 6));
    EXPECT_TRUE(sorts(MergeExchange<12>(), 12));
    EXPECT_EQ(MergeExchange<6>().count, 12u);
    EXPECT_EQ(MergeExchange<12>().count, 41u);
}

TEST(SortFew, SortsAsAStableSortDoes) {
    std::mt19937_64 random(1);
    const auto below = [&](u64 bound) { return random() % bound; };
    for (u32 trial = 0; trial < 20000; ++trial) {
        const u32 count = trial % 17;
        // Rounds that are all alike, mostly alike, and not.
        const u64 rounds = trial % 3 == 0 ? 1 : trial % 3 == 1 ? 2 : 9, values = below(2) == 0 ? 4 : 1000;
        std::vector<Told::Row> told(count);
        for (Told::Row& row : told)
            row = {below(3) == 0 ? static_cast<i64>(below(rounds)) : 0, std::ldexp(static_cast<double>(below(values)) - 300, 4)};
        expect_sorted<Told>(told, std::to_string(count) + " facts");
        expect_sorted<Plain>(told, std::to_string(count) + " facts of another type");
    }
}

TEST(SortFew, SortsEachTypeToItsGreatestValues) {
    std::mt19937_64 random(2);
    const auto try_type = [&]<class V>(V least, V greatest) {
        for (u32 trial = 0; trial < 2000; ++trial) {
            std::vector<typename Token<V>::Row> rows(trial % 14);
            for (auto& row : rows) {
                const u64 draw = random();
                row.a1 = draw % 5 == 0 ? least : draw % 5 == 1 ? greatest : static_cast<V>(draw >> 8 & 127);
            }
            expect_sorted<Token<V>>(rows, std::to_string(sizeof(V)) + " bytes, " + std::to_string(rows.size()) + " facts");
        }
    };
    const auto limits = [&]<class V>(V) { try_type(std::numeric_limits<V>::lowest(), std::numeric_limits<V>::max()); };
    limits(double{});
    limits(i64{});
    limits(i32{});
    limits(std::int16_t{});
    limits(u64{});
    limits(bool{});
}

}  // namespace
}  // namespace meld
