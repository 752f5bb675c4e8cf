// Answers hold each row once, in memory for rows and not for the ways to them.
#include "runtime/ask/query/table.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "runtime/engine/tuple/values.h"

namespace meld::inspect {
namespace {

using check::Type;

TEST(Table, RowsThatComeAgainTakeNoMemory) {
    tuple::Arena lists;
    const std::vector<Value> texts = {{.list = lists.text("b")}, {.list = lists.text("a")}};
    Table table({{"S", Type::String}, {"I", Type::Int}});
    std::uint64_t most = 0;
    for (std::int64_t i = 0; i < 2'500'000; ++i) {
        table.add({texts[static_cast<std::size_t>(i % 2)], {.integer = i % 3}});
        most = std::max(most, table.rows());
    }
    EXPECT_LE(most, std::uint64_t{1} << 20);
    table.finish();
    EXPECT_EQ(table.rows_json(9).dump(), R"([["a",0],["a",1],["a",2],["b",0],["b",1],["b",2]])");
}

TEST(Table, RowsThatDifferAreKept) {
    Table table({{"I", Type::Int}});
    for (std::int64_t i = 0; i < 3'000'000; ++i) table.add({{.integer = i ^ 1}});
    table.finish();
    ASSERT_EQ(table.rows(), 3'000'000U);
    for (std::size_t i = 0; i < table.rows(); ++i) ASSERT_EQ(table.cell(i, 0).integer, static_cast<std::int64_t>(i));
}

}  // namespace
}  // namespace meld::inspect
