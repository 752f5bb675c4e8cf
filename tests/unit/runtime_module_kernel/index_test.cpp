// Rows found by some of their arguments are those that looking at all of them finds, in the same order, also while a search takes some.
#include "runtime/module/kernel/index.h"

#include <algorithm>
#include <random>
#include <vector>

#include "tests/unit/runtime_module_kernel/scratch.h"

namespace meld {
namespace {

struct Entry {
    struct Row {
        i64 a1, a2;
    };
    static int key(const Row& a, const Row& b) { return a.a1 != b.a1 ? (a.a1 < b.a1 ? -1 : 1) : a.a2 < b.a2 ? -1 : b.a2 < a.a2 ? 1 : 0; }
};
struct ByFirst {
    using Row = Entry::Row;
    static int order(const Row& a, const Row& b) { return a.a1 < b.a1 ? -1 : b.a1 < a.a1 ? 1 : 0; }
};
struct HashedBySecond {
    using Row = Entry::Row;
    static u64 hash(const Row& row) { return static_cast<u64>(row.a2); }
};

struct Tables : ScratchTest {
    std::vector<Entry::Row> rows(u32 count, i64 values) {
        std::vector<Entry::Row> out;
        for (u32 i = 0; i < count; ++i)
            out.push_back({static_cast<i64>(random() % static_cast<u64>(values)), static_cast<i64>(random() % static_cast<u64>(values))});
        std::ranges::sort(out, [](const auto& a, const auto& b) { return Entry::key(a, b) < 0; });
        return out;
    }
    std::mt19937_64 random{7};
};

TEST_F(Tables, SpansAreTheRowsThatBeginAlike) {
    for (const u32 count : {0u, 1u, 16u, 17u, 100u, 1000u}) {
        const std::vector<Entry::Row> all = rows(count, 20);
        for (i64 x = -1; x <= 20; ++x) {
            const Span span = find_span<ByFirst>(all.data(), count, {x, 0});
            for (u32 i = 0; i < count; ++i) EXPECT_EQ(i >= span.first && i < span.end, all[i].a1 == x) << count << " " << x << " " << i;
        }
    }
}

TEST_F(Tables, IndexesFindRowsInTheirOrder) {
    for (const u32 count : {0u, 1u, 16u, 17u, 100u, 1000u}) {
        const std::vector<Entry::Row> all = rows(count, 20);
        Index<HashedBySecond> index;
        for (i64 x = -1; x <= 20; ++x) {
            const Found found = index.find(e, all.data(), count, {0, x});
            std::vector<u32> got, expected;
            for (u32 k = found.first; k < count; k = found.after(k))
                if (all[k].a2 == x) got.push_back(k);
            for (u32 k = 0; k < count; ++k)
                if (all[k].a2 == x) expected.push_back(k);
            EXPECT_EQ(got, expected) << count << " " << x;
            EXPECT_EQ(found.next != nullptr, count > kScannedRows && static_cast<u32>(x + 1) >= kScansBefore);
        }
    }
}

TEST_F(Tables, AnIndexIsMadeAnewForOtherRows) {
    const std::vector<Entry::Row> some = rows(50, 5), more = rows(60, 5);
    Index<HashedBySecond> index;
    for (int i = 0; i < 6; ++i) index.find(e, some.data(), 50, {0, 1});
    EXPECT_NE(index.find(e, some.data(), 50, {0, 1}).next, nullptr);
    EXPECT_EQ(index.find(e, more.data(), 60, {0, 1}).next, nullptr);
    EXPECT_EQ(index.find(e, some.data(), 49, {0, 1}).next, nullptr);
}

TEST_F(Tables, WhatIsTakenIsFoundNoMore) {
    for (const u32 count : {1u, 20u, 300u}) {
        const std::vector<Entry::Row> all = rows(count, 6);
        Index<HashedBySecond> index;
        Taken taken;
        std::vector<bool> gone(count);
        for (u32 step = 0; step < 3 * count; ++step) {
            const i64 x = static_cast<i64>(random() % 6);
            const Found found = index.find(e, all.data(), count, {0, x}, taken);
            std::vector<u32> got, expected;
            for (u32 k = found.start(count, taken); k < count; k = found.after(k, count, taken))
                if (all[k].a2 == x) got.push_back(k);
            for (u32 k = 0; k < count; ++k)
                if (!gone[k] && all[k].a2 == x) expected.push_back(k);
            ASSERT_EQ(got, expected) << count << " " << step;
            if (expected.empty()) continue;
            const u32 at = expected[random() % expected.size()];
            taken.take(e, count, at);
            gone[at] = true;
            u32 next = at;
            while (next < count && gone[next]) ++next;
            EXPECT_EQ(taken.from(at), next);
        }
    }
}

TEST_F(Tables, ABagDropsWhatWasTaken) {
    for (const bool stored : {false, true})
        for (const u32 count : {1u, 5u, 40u})
            for (int trial = 0; trial < 20; ++trial) {
                std::vector<Entry::Row> all = rows(count, 9);
                const std::vector<Entry::Row> before = all;
                Bag<Entry> bag{};
                bag.open(all.data(), count, 0);
                if (!stored) bag.own(e);
                Taken taken;
                std::vector<Entry::Row> left;
                // Some from the front, or any.
                for (u32 i = 0; i < count; ++i)
                    if (trial % 2 == 0 ? i < random() % count : random() % 2 == 0)
                        taken.take(e, count, i);
                    else
                        left.push_back(all[i]);
                bag.drop(e, taken);
                bag.add(e, {4, 4});
                bag.arrange(e);
                left.push_back({4, 4});
                std::ranges::sort(left, [](const auto& a, const auto& b) { return Entry::key(a, b) < 0; });
                ASSERT_EQ(bag.list.count, left.size());
                for (u32 i = 0; i < bag.list.count; ++i) EXPECT_EQ(Entry::key(bag.list.rows[i], left[i]), 0);
                for (u32 i = 0; stored && i < count; ++i) EXPECT_EQ(Entry::key(all[i], before[i]), 0) << "what is stored was written to";
            }
}

TEST_F(Tables, AFactChangesInItsPlaceIfThatKeepsTheOrder) {
    std::vector<Entry::Row> all = {{1, 1}, {2, 5}, {3, 1}};
    Bag<Entry> bag{};
    bag.open(all.data(), 3, 0);
    EXPECT_TRUE(bag.change(e, 1, {2, 9}));
    EXPECT_FALSE(bag.change(e, 1, {3, 2}));
    EXPECT_FALSE(bag.change(e, 1, {0, 2}));
    EXPECT_TRUE(bag.change(e, 1, {3, 1}));
    EXPECT_EQ(bag.list.rows[1].a1, 3);
    EXPECT_EQ(all[1].a2, 5) << "what is stored was written to";
}

}  // namespace
}  // namespace meld
