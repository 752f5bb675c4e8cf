#include "runtime/world/ensemble/catom_ids.h"

#include <gtest/gtest.h>

namespace meld::world {
namespace {

constexpr auto kAll = [](std::uint32_t) { return true; };

std::optional<std::uint32_t> index_of(const CatomIds& ids, std::uint64_t id) {
    if (const auto index = ids.index_in_order(id)) return index;
    return ids.find(id);
}

TEST(CatomIds, StoresNothingForConsecutiveIds) {
    CatomIds ids;
    ids.add_run(100, 1000);
    for (std::uint64_t id = 1100; id < 1200; ++id) ids.add(id);
    EXPECT_EQ(ids.of(0), 100U);
    EXPECT_EQ(ids.of(1099), 1199U);
    EXPECT_EQ(ids.bytes(), 0U);
    EXPECT_EQ(ids.index_in_order(1150), std::optional<std::uint32_t>(1050));
    EXPECT_FALSE(ids.index_in_order(99));
    EXPECT_FALSE(ids.index_in_order(1200));
}

TEST(CatomIds, StoresOnlyThoseAfterTheFirstThatBreaksTheRow) {
    CatomIds ids;
    ids.add_run(10, 5);
    ids.add_run(7, 2);
    ids.add(17);
    EXPECT_EQ(ids.of(4), 14U);
    EXPECT_EQ(ids.of(5), 7U);
    EXPECT_EQ(ids.of(6), 8U);
    EXPECT_EQ(ids.of(7), 17U);
    ids.make_table(kAll);
    EXPECT_EQ(index_of(ids, 8), std::optional<std::uint32_t>(6));
    EXPECT_EQ(index_of(ids, 17), std::optional<std::uint32_t>(7));
    EXPECT_EQ(index_of(ids, 9), std::nullopt);
}

TEST(CatomIds, FindsAllAfterAnIndexHasAnotherId) {
    CatomIds ids;
    ids.add_run(0, 4);
    ids.add_run(50, 3);
    ids.make_table(kAll);
    ids.leave(1);
    ids.replace(1, 99);
    ids.enter(1);
    EXPECT_EQ(ids.of(0), 0U);
    EXPECT_EQ(ids.of(1), 99U);
    EXPECT_EQ(index_of(ids, 1), std::nullopt);
    EXPECT_EQ(index_of(ids, 99), std::optional<std::uint32_t>(1));
    EXPECT_EQ(index_of(ids, 3), std::optional<std::uint32_t>(3));
    for (std::uint64_t id = 50; id < 53; ++id) EXPECT_EQ(index_of(ids, id), std::optional<std::uint32_t>(id - 46));
    ids.leave(5);
    ids.replace(5, 1);
    ids.enter(5);
    EXPECT_EQ(index_of(ids, 51), std::nullopt);
    EXPECT_EQ(index_of(ids, 1), std::optional<std::uint32_t>(5));
    Geometry g;
    ids.add_to(g);
    for (u32 index = 0; index < 7; ++index) EXPECT_EQ(id_of(g, index), ids.of(index));
}

}  // namespace
}  // namespace meld::world
