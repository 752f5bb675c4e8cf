// Rows that are added where they are said to come are where they would be found to come, and readers see the same changes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <random>
#include <vector>

#include "runtime/engine/tuple/columns.h"

namespace meld::tuple {
namespace {

int by_number(const void* a, const void* b) {
    i32 x = 0, y = 0;
    std::memcpy(&x, a, sizeof x);
    std::memcpy(&y, b, sizeof y);
    return x < y ? -1 : y < x;
}

// Rows of so many bytes, of which the first four are a number that names the group.
class FollowedRows {
  public:
    explicit FollowedRows(u32 row_bytes) : row_bytes_(row_bytes) {
        column_.name = "row";
        column_.rows = column_.exported = true;
        column_.stride = sizeof(RowsHead);
        column_.row_bytes = row_bytes;
        column_.compare_groups = by_number;
        info_.column_count = 1;
        info_.columns = &column_;
    }
    const ModuleInfo& info() const { return info_; }

    // Adds rows of these groups; placed: it says where.
    void add(Columns& columns, const std::vector<i32>& groups, const std::vector<u32>& places, bool placed) const {
        const auto n = static_cast<u32>(groups.size());
        RowChanges* c = columns.changes().make(0, 0, n + (n * 4 + 4 + row_bytes_ - 1) / row_bytes_, 0);
        c->added = n;
        c->placed = placed;
        auto* row = reinterpret_cast<u8*>(c + 1);
        for (const i32 group : groups) {
            std::memset(row, group & 0xff, row_bytes_);
            std::memcpy(row, &group, sizeof group);
            row += row_bytes_;
        }
        if (placed) std::memcpy(const_cast<u32*>(places_of(*c, row_bytes_)), places.data(), n * sizeof(u32));
        columns.change_rows(0, 0, c, 0);
    }
    std::vector<u8> rows(const Columns& columns) const {
        const RowsHead& head = columns.rows(0, 0);
        return {head.data, head.data + std::size_t{head.count} * row_bytes_};
    }

  private:
    u32 row_bytes_;
    ColumnInfo column_{};
    ModuleInfo info_{};
};

TEST(ColumnChanges, AddRowsWhereTheySayThatTheyCome) {
    std::mt19937 random{5};
    for (const u32 row_bytes : {4u, 8u, 12u, 16u, 24u}) {
        const FollowedRows module(row_bytes);
        Columns placed(module.info(), 1), found(module.info(), 1);
        placed.resize(1);
        found.resize(1);
        std::vector<i32> held;
        for (const u32 count : {1u, 3u, 1u, 40u, 8u, 200u, 2u, 700u}) {
            placed.changes().begin_evaluation();
            found.changes().begin_evaluation();
            std::vector<i32> groups;
            while (groups.size() < count) {
                const i32 group = static_cast<i32>(random() % 5000) - 2500;
                if (std::ranges::find(held, group) == held.end() && std::ranges::find(groups, group) == groups.end())
                    groups.push_back(group);
            }
            std::ranges::sort(groups);
            std::vector<u32> places;
            for (const i32 group : groups) places.push_back(static_cast<u32>(std::ranges::lower_bound(held, group) - held.begin()));
            module.add(placed, groups, places, true);
            module.add(found, groups, places, false);
            held.insert(held.end(), groups.begin(), groups.end());
            std::ranges::sort(held);
            EXPECT_EQ(placed.rows(0, 0).count, held.size());
            EXPECT_EQ(module.rows(placed), module.rows(found)) << row_bytes << " bytes, " << count << " rows";
            EXPECT_EQ(placed.rows(0, 0).capacity, found.rows(0, 0).capacity);
            ASSERT_NE(placed.changes().of(0, 0), nullptr);
            EXPECT_EQ(placed.changes().of(0, 0)->added, count);
            placed.changes().end_evaluation();
            found.changes().end_evaluation();
        }
    }
}

}  // namespace
}  // namespace meld::tuple
