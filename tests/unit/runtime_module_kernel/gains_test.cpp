// What catoms take of the rows that their neighbours have gained is what deciding each group would take, in order, and the changes lead
// from the rows before to those after.
#include "runtime/module/kernel/deltas.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <vector>

#include "tests/unit/runtime_module_kernel/scratch.h"

namespace meld {
namespace {

struct Reached {
    struct Row {
        i64 a1;
        u32 rank;
    };
    static constexpr Reduce kReduce = Reduce::Set;
    static constexpr bool kRanked = true, kLinks = true, kKeyed = true, kWaits = false, kFollowed = true, kGrows = false, kShared = false;
    static constexpr u16 kPredicate = 1;
    static int key(const Row& a, const Row& b) { return compare(a.a1, b.a1); }
    static bool better(const Row&, const Row&) { return false; }
    static bool same(const Row&, const Row&) { return true; }
    static bool before(const Row&, const Row&) { return false; }
    static u64 hash(const Row& row) { return mix(0, bits_of(row.a1)); }
    static Row row(i64 group, i64, u32 rank) { return {group, rank}; }
    static i64 value(const Row&) { return 0; }
};

struct Nearest {
    struct Row {
        i64 a1, a2;
        u32 rank;
    };
    static constexpr Reduce kReduce = Reduce::Best;
    static constexpr bool kRanked = true, kLinks = true, kKeyed = true, kWaits = false, kFollowed = true, kGrows = false, kShared = false;
    static constexpr u16 kPredicate = 1;
    static int key(const Row& a, const Row& b) { return compare(a.a1, b.a1); }
    static bool better(const Row& a, const Row& b) { return a.a2 < b.a2; }
    static bool same(const Row& a, const Row& b) { return a.a2 == b.a2; }
    static bool before(const Row&, const Row&) { return false; }
    static u64 hash(const Row& row) { return mix(0, bits_of(row.a1)); }
    static Row row(i64 group, i64 value, u32 rank) { return {group, value, rank}; }
    static i64 value(const Row& row) { return row.a2; }
};

// How many rows a catom holds, and how many each of its neighbours has gained.
struct Sizes {
    u32 held, neighbours, gained;
    i64 groups;
};

struct GainedRows : ScratchTest {
    template <class T>
    std::vector<typename T::Row> some_rows(u32 count, i64 groups, bool in_order) {
        std::vector<typename T::Row> rows;
        for (u32 i = 0; i < count; ++i)
            rows.push_back(T::row(static_cast<i64>(random() % static_cast<u64>(groups)), static_cast<i64>(random() % 5),
                                  static_cast<u32>(random() % 4)));
        if (!in_order) return rows;
        std::ranges::stable_sort(rows, [](const auto& a, const auto& b) { return T::key(a, b) < 0; });
        const auto same_group = [](const auto& a, const auto& b) { return T::key(a, b) == 0; };
        rows.erase(std::unique(rows.begin(), rows.end(), same_group), rows.end());
        return rows;
    }

    // The rows after, group by group, by the function that decides groups one at a time.
    template <class T>
    std::map<i64, typename T::Row> decided(const std::vector<typename T::Row>& held, const std::vector<typename T::Row>& gained) {
        std::map<i64, std::vector<typename T::Row>> proposals;
        std::map<i64, typename T::Row> all;
        for (const auto& row : held) {
            all[row.a1] = row;
            proposals[row.a1].push_back(row);  // What supports it is still there.
        }
        for (const auto& row : gained) proposals[row.a1].push_back(row);
        for (const auto& [group, rows] : proposals) {
            typename T::Row out;
            const auto current = all.find(group);
            const bool holds =
                decide_group<T>(e, {}, current == all.end() ? nullptr : &current->second, rows.data(), static_cast<u32>(rows.size()), out);
            EXPECT_TRUE(holds);
            all[group] = out;
        }
        return all;
    }

    template <class T>
    void expect_as_decided(const Sizes& sizes, bool in_order) {
        using Row = typename T::Row;
        const std::vector<Row> held = some_rows<T>(sizes.held, sizes.groups, true);
        std::vector<Row> all;
        Gains<T> gains;
        for (u32 n = 0; n < sizes.neighbours; ++n) {
            const std::vector<Row> rows = some_rows<T>(sizes.gained, sizes.groups, in_order);
            Row* to = gains.room(e, static_cast<u32>(rows.size()));
            gains.end(e, std::ranges::copy(rows, to).out);
            all.insert(all.end(), rows.begin(), rows.end());
        }
        const std::map<i64, Row> expected = decided<T>(held, all);

        Relation<T> relation{};
        relation.open(held.data(), static_cast<u32>(held.size()), 0);
        ASSERT_TRUE(gains.merge(e, relation));
        // The same without the rows: the same changes.
        Relation<T> only_changes = relation;
        Gains<T> again;
        again.end(e, std::copy_n(gains.rows.rows, gains.rows.count, again.room(e, gains.rows.count)));
        const bool changed = take_gains<true>(e, relation, gains);
        EXPECT_EQ(take_gains<false>(e, only_changes, again), changed);
        if (changed) {
            const RowChanges &a = *relation.changes, &b = *only_changes.changes;
            ASSERT_EQ(a.removed, b.removed);
            ASSERT_EQ(a.added, b.added);
            EXPECT_EQ(a.placed, b.placed);
            for (u32 i = 0; i < a.removed + a.added; ++i) EXPECT_EQ(rows_in<Row>(&a)[i].a1, rows_in<Row>(&b)[i].a1);
        }
        ASSERT_EQ(relation.count, expected.size());
        u32 at = 0;
        for (const auto& [group, row] : expected) {
            EXPECT_EQ(relation.rows[at].a1, group);
            EXPECT_EQ(T::value(relation.rows[at]), T::value(row));
            EXPECT_EQ(relation.rows[at].rank, row.rank);
            ++at;
        }
        EXPECT_EQ(changed, relation.changed);
        if (changed) expect_changes<T>(held, relation);
    }

    // The changes, applied to the rows before, make those after; each added row says where it comes.
    template <class T>
    void expect_changes(const std::vector<typename T::Row>& held, const Relation<T>& relation) {
        using Row = typename T::Row;
        ASSERT_NE(relation.changes, nullptr);
        const RowChanges& c = *relation.changes;
        EXPECT_EQ(c.placed, c.removed == 0 ? 1u : 0u);
        const Row* const rows = rows_in<Row>(&c);
        std::map<i64, Row> after;
        for (const Row& row : held) after[row.a1] = row;
        for (u32 i = 0; i < c.removed; ++i) EXPECT_EQ(after.erase(rows[i].a1), 1u);
        for (u32 i = 0; i < c.added; ++i) {
            const Row& row = rows[c.removed + i];
            EXPECT_TRUE(after.emplace(row.a1, row).second);
            if (c.placed == 0) continue;
            const u32 place = places_of(c, sizeof(Row))[i];
            EXPECT_TRUE(place == 0 || held[place - 1].a1 < row.a1);
            EXPECT_TRUE(place == held.size() || row.a1 < held[place].a1);
        }
        EXPECT_EQ(after.size(), relation.count);
        for (u32 i = 0; i < relation.count; ++i) {
            EXPECT_EQ(T::value(after[relation.rows[i].a1]), T::value(relation.rows[i]));
            EXPECT_EQ(after[relation.rows[i].a1].rank, relation.rows[i].rank);
        }
    }

    std::mt19937_64 random{31};
};

TEST_F(GainedRows, EnterAsIfEachGroupWereDecided) {
    for (const Sizes sizes : {Sizes{0, 1, 1, 5},
                              {0, 3, 40, 60},
                              {30, 3, 40, 60},
                              {30, 6, 20, 1000},
                              {500, 2, 3, 600},
                              {500, 5, 10, 5000},
                              {3, 12, 1, 4},
                              {200, 3, 0, 300}})
        for (const bool in_order : {true, false})
            for (int i = 0; i < 20; ++i) {
                SCOPED_TRACE(testing::Message() << sizes.held << " held, " << sizes.neighbours << " x " << sizes.gained);
                expect_as_decided<Reached>(sizes, in_order);
                expect_as_decided<Nearest>(sizes, in_order);
            }
}

TEST_F(GainedRows, ThatCouldExceedTheLimitAreLeftToOthers) {
    view.max_facts = 3;
    const Reached::Row held[] = {{1, 0}, {2, 0}}, gained[] = {{1, 1}, {3, 1}};
    Relation<Reached> relation{};
    relation.open(held, 2, 0);
    Gains<Reached> gains;
    gains.end(e, std::ranges::copy(gained, gains.room(e, 2)).out);
    EXPECT_FALSE(gains.merge(e, relation));
    EXPECT_EQ(relation.count, 2u);
}

TEST_F(GainedRows, AreTrustedWhereNothingIsRemembered) {
    view.tombstones = true;
    host.tombstone = [](Eval*, u16 predicate, u64, Tombstone*) { return predicate == kNone16; };
    EXPECT_FALSE(has_lost_nothing(e));
    host.tombstone = [](Eval*, u16, u64, Tombstone*) { return false; };
    EXPECT_TRUE(has_lost_nothing(e));
}

}  // namespace
}  // namespace meld
