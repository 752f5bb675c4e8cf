// Rows that arrive for many catoms: who holds them, in which order, and what becomes of those that nobody consumes.
#include "runtime/engine/tuple/arrived_rows.h"

#include <gtest/gtest.h>

#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/engine/tuple/columns.h"
#include "runtime/module/kernel/bags.h"
#include "tests/unit/runtime_engine_tuple/types.h"

namespace meld::tuple {
namespace {

struct Token {
    struct Row {
        i64 a1;
    };
    static int key(const Row& a, const Row& b) { return (a.a1 > b.a1) - (a.a1 < b.a1); }
};

// token(node, int), linear.
class Arrivals : public testing::Test {
  protected:
    Arrivals() {
        field_ = {"n", ValueType::Int, 8, 0, Types::kInt};
        predicate_ = {"token", PredicateKind::Linear, Storage::Rows, false, false, 1, &field_, 0, 0, kNone32, 0, 0};
        column_ = {
            "token",
            true,
            false,
            sizeof(RowsHead),
            sizeof(Token::Row),
            64,
            0,
            nullptr,
            0,
            nullptr,
            nullptr,
            nullptr,
            [](const void* a, const void* b) { return Token::key(*static_cast<const Token::Row*>(a), *static_cast<const Token::Row*>(b)); },
            arrange_rows<Token, true>};
        info_.types = types_.table();
        info_.predicate_count = info_.column_count = 1;
        info_.predicates = &predicate_;
        info_.columns = &column_;
        columns_.emplace(info_, 2);
    }
    void resize(std::size_t catoms) { columns_->resize(catoms); }
    void arrive(const std::vector<std::pair<u32, i64>>& rows) {
        ArrivedRows& arrived = columns_->arrived();
        arrived.open(0, false);
        const auto here = [](u32) { return true; };
        const auto count = arrived.counter(here);
        for (const auto& [to, n] : rows) count(&to, 1);
        arrived.make_room();
        const auto place = arrived.placer<sizeof(Token::Row)>(here);
        for (const auto& [to, n] : rows) {
            const Token::Row row{n};
            place(&to, 1, reinterpret_cast<const u8*>(&row));
        }
        arrived.end(workers_);
    }
    void hold(u32 catom, const std::vector<i64>& rows) { columns_->set_rows(0, catom, rows.data(), static_cast<u32>(rows.size()), 0); }
    std::vector<i64> held(u32 catom) const {
        const RowsHead& head = columns_->rows(0, catom);
        const i64* rows = reinterpret_cast<const i64*>(head.data);
        return {rows, rows + head.count};
    }

    Types types_;
    FieldInfo field_;
    PredicateInfo predicate_;
    ColumnInfo column_;
    ModuleInfo info_{};
    std::optional<Columns> columns_;
    Workers workers_{2};
};

TEST_F(Arrivals, AreSortedByReceiver) {
    resize(4);
    arrive({{2, 5}, {0, 1}, {2, -3}, {2, 5}, {3, 0}});
    EXPECT_EQ(held(0), (std::vector<i64>{1}));
    EXPECT_TRUE(held(1).empty());
    EXPECT_EQ(held(2), (std::vector<i64>{-3, 5, 5}));
    EXPECT_EQ(columns_->arrived().receivers(), (std::vector<u32>{2, 0, 3}));
}

TEST_F(Arrivals, MergeWithWhatIsHeld) {
    resize(2);
    hold(0, {1, 4, 4, 9});
    arrive({{0, 4}, {0, 12}, {0, 0}, {0, 5}});
    EXPECT_EQ(held(0), (std::vector<i64>{0, 1, 4, 4, 4, 5, 9, 12}));
    arrive({{0, 3}, {1, 3}});
    EXPECT_EQ(held(0), (std::vector<i64>{0, 1, 3, 4, 4, 4, 5, 9, 12}));
    EXPECT_EQ(held(1), (std::vector<i64>{3}));
}

TEST_F(Arrivals, StayWhenOthersArrive) {
    resize(3);
    arrive({{0, 7}, {1, 8}});
    arrive({{2, 1}});
    arrive({{2, 0}});
    EXPECT_EQ(held(0), (std::vector<i64>{7}));
    EXPECT_EQ(held(1), (std::vector<i64>{8}));
    EXPECT_EQ(held(2), (std::vector<i64>{0, 1}));
}

TEST_F(Arrivals, StayInLessMemoryWhenNothingArrives) {
    resize(3000);
    std::vector<std::pair<u32, i64>> rows;
    for (u32 i = 0; i < 100000; ++i) rows.push_back({i % 3000, i});
    arrive(rows);
    const std::vector<i64> before = held(7);
    for (u32 catom = 8; catom < 3000; ++catom) columns_->clear(catom, 0);
    const std::size_t bytes = columns_->arrived().bytes();
    columns_->arrived().rest();
    EXPECT_EQ(columns_->arrived().bytes(), bytes);
    columns_->arrived().rest();
    EXPECT_EQ(columns_->arrived().bytes(), 0u);
    EXPECT_EQ(held(7), before);
    arrive({{7, -1}});
    EXPECT_EQ(held(7).front(), -1);
    EXPECT_EQ(held(7).size(), before.size() + 1);
}

TEST_F(Arrivals, CanBeChangedLikeOtherRows) {
    resize(2);
    arrive({{0, 7}, {0, 8}, {1, 3}});
    const i64 between = 5;
    columns_->insert_row(0, 1, 1, &between, 0);
    EXPECT_EQ(held(1), (std::vector<i64>{3, 5}));
    hold(0, {8});
    EXPECT_EQ(held(0), (std::vector<i64>{8}));
    columns_->clear(1, 0);
    arrive({{0, 1}});
    EXPECT_EQ(held(0), (std::vector<i64>{1, 8}));
    EXPECT_TRUE(held(1).empty());
}

TEST_F(Arrivals, ManyForOneCatomAndForManyCatoms) {
    resize(5000);
    std::vector<std::pair<u32, i64>> rows;
    for (i64 i = 0; i < 3000; ++i) rows.push_back({17, i * 7919 % 3000});
    for (u32 catom = 100; catom < 5000; ++catom) rows.push_back({catom, catom});
    arrive(rows);
    std::vector<i64> all(3000);
    std::iota(all.begin(), all.end(), 0);
    EXPECT_EQ(held(17), all);
    for (u32 catom = 100; catom < 5000; ++catom) ASSERT_EQ(held(catom), (std::vector<i64>{catom}));
}

}  // namespace
}  // namespace meld::tuple
