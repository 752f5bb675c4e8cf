// Who owns the lists of facts: columns, through giving and taking, packing, clearing, and writing one column from another.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "runtime/engine/tuple/facts.h"
#include "runtime/engine/tuple/value_text.h"
#include "tests/unit/runtime_engine_tuple/types.h"

namespace meld::tuple {
namespace {

// path(node, list int, string), rows; name(node, string), a record; count(node, int), a record without lists; speed(node, vec3)
// and turn(node, float, float), which share a record.
class Module {
  public:
    Module() {
        string_ = types_.add(ValueType::String);
        list_ = types_.add(ValueType::List, {Types::kInt});
        vec3_ = types_.add(ValueType::Vec3);
        path_fields_[0] = {"route", ValueType::List, 8, 0, list_};
        path_fields_[1] = {"label", ValueType::String, 8, 8, string_};
        name_fields_[0] = {"text", ValueType::String, 8, 0, string_};
        count_fields_[0] = {"n", ValueType::Int, 8, 0, Types::kInt};
        path_types_[0] = list_;
        path_types_[1] = string_;
        speed_fields_[0] = {"v", ValueType::Vec3, 8, 0, vec3_};
        turn_fields_[0] = {"x", ValueType::Float, 8, 8, Types::kFloat};
        turn_fields_[1] = {"y", ValueType::Float, 8, 16, Types::kFloat};
        predicates_[0] = {"path", PredicateKind::Persistent, Storage::Rows, false, false, 2, path_fields_, 0, 0, kNone32, 0, 0};
        predicates_[1] = {"name", PredicateKind::Persistent, Storage::Single, false, false, 1, name_fields_, 1, 1, kNone32, 8, 1};
        predicates_[2] = {"count", PredicateKind::Persistent, Storage::Single, false, false, 1, count_fields_, 2, 2, kNone32, 8, 1};
        predicates_[3] = {"speed", PredicateKind::Sensed, Storage::Single, false, false, 1, speed_fields_, 3, 3, kNone32, 24, 1};
        predicates_[4] = {"turn", PredicateKind::Sensed, Storage::Single, false, false, 2, turn_fields_, 3, 4, kNone32, 24, 2};
        columns_[0] = {"path", true, false, sizeof(RowsHead), 16, 0, 0, nullptr, 2, path_offsets_, path_types_, nullptr, nullptr, nullptr};
        columns_[1] = {"name", false, true, 16, 0, 0, 0, nullptr, 1, path_offsets_, &string_, nullptr, nullptr, nullptr};
        columns_[2] = {"count", false, false, 16, 0, 0, 0, nullptr, 0, nullptr, nullptr, nullptr, nullptr, nullptr};
        columns_[3] = {"speed+turn", false, false, 32, 0, 0, 0, nullptr, 1, path_offsets_, &vec3_, nullptr, nullptr, nullptr};
        info_.types = types_.table();
        info_.predicate_count = 5;
        info_.predicates = predicates_;
        info_.column_count = 4;
        info_.columns = columns_;
    }
    const ModuleInfo& info() const { return info_; }

    static constexpr u32 kPath = 0, kName = 1, kCount = 2, kSpeed = 3, kTurn = 4;

  private:
    Types types_;
    u16 string_ = 0, list_ = 0, vec3_ = 0;
    FieldInfo path_fields_[2], name_fields_[1], count_fields_[1], speed_fields_[1], turn_fields_[2];
    u32 path_offsets_[2] = {0, 8};
    u16 path_types_[2];
    PredicateInfo predicates_[5];
    ColumnInfo columns_[4];
    ModuleInfo info_{};
};

class ColumnsWithLists : public testing::Test {
  protected:
    ColumnsWithLists() {
        columns_.emplace(module_.info(), 2);
        columns_->resize(4);
    }
    // The arguments as text, which must be of the predicate's types.
    bool change(bool give, u32 predicate, u32 catom, const std::vector<std::string>& arguments, int pool = 0) {
        Arena arena;
        std::vector<Value> values;
        const PredicateInfo& p = module_.info().predicates[predicate];
        for (u32 i = 0; i < p.arity; ++i) values.push_back(*parse_value(type_of(module_.info(), p.fields[i]), arguments[i], arena));
        return (give ? give_fact : take_fact)(module_.info(), *columns_, predicate, catom, values.data(), pool);
    }
    bool give(u32 predicate, u32 catom, const std::vector<std::string>& arguments, int pool = 0) {
        return change(true, predicate, catom, arguments, pool);
    }
    bool take(u32 predicate, u32 catom, const std::vector<std::string>& arguments) { return change(false, predicate, catom, arguments); }
    std::string facts(u32 predicate, u32 catom) const {
        std::string text;
        each_fact(module_.info(), *columns_, Geometry{}, predicate, catom,
                  [&](const Value* v) { text += print_fact(module_.info(), module_.info().predicates[predicate], catom, v) + " "; });
        return text;
    }
    std::size_t list_bytes() { return columns_->lists().bytes(); }

    Module module_;
    std::optional<Columns> columns_;
};

TEST_F(ColumnsWithLists, FactsAreTheSameByContent) {
    EXPECT_TRUE(give(Module::kPath, 1, {"[2, 1]", "b"}));
    EXPECT_TRUE(give(Module::kPath, 1, {"[2]", "c"}));
    EXPECT_TRUE(give(Module::kPath, 1, {"[2, 1]", "a"}, 1));
    EXPECT_FALSE(give(Module::kPath, 1, {"[2, 1]", "b"}));
    EXPECT_EQ(facts(Module::kPath, 1), R"(path(@1, [2], "c") path(@1, [2, 1], "a") path(@1, [2, 1], "b") )");
    EXPECT_FALSE(take(Module::kPath, 1, {"[1]", "b"}));
    EXPECT_TRUE(take(Module::kPath, 1, {"[2, 1]", "a"}));
    EXPECT_TRUE(take(Module::kPath, 1, {"[2]", "c"}));
    EXPECT_EQ(facts(Module::kPath, 1), R"(path(@1, [2, 1], "b") )");
    EXPECT_TRUE(take(Module::kPath, 1, {"[2, 1]", "b"}));
    EXPECT_EQ(list_bytes(), 0u);
}

TEST_F(ColumnsWithLists, ASingleIsReplacedAndReleased) {
    EXPECT_TRUE(give(Module::kName, 0, {"long enough to take a few words"}));
    const std::size_t once = list_bytes();
    EXPECT_FALSE(give(Module::kName, 0, {"long enough to take a few words"}));
    EXPECT_EQ(list_bytes(), once);
    EXPECT_TRUE(give(Module::kName, 0, {"short"}));
    EXPECT_LT(list_bytes(), once);
    EXPECT_EQ(facts(Module::kName, 0), "name(@0, \"short\") ");
    EXPECT_TRUE(take(Module::kName, 0, {"short"}));
    EXPECT_EQ(facts(Module::kName, 0), "");
    EXPECT_EQ(list_bytes(), 0u);
}

TEST_F(ColumnsWithLists, ColumnsWithoutListsHaveNone) {
    EXPECT_TRUE(give(Module::kCount, 0, {"12"}));
    EXPECT_EQ(facts(Module::kCount, 0), "count(@0, 12) ");
    EXPECT_EQ(list_bytes(), 0u);
}

TEST_F(ColumnsWithLists, PackedCatomsHaveCopiesOfTheirOwn) {
    give(Module::kPath, 0, {"[1, 2]", "first"});
    give(Module::kPath, 0, {"[]", ""});
    give(Module::kName, 0, {"zero"});
    give(Module::kCount, 0, {"-3"});
    give(Module::kPath, 1, {"[9]", "replaced"});
    ByteWriter bytes;
    columns_->pack(0, Columns::Which::All, bytes);
    columns_->clear(0, 0);
    EXPECT_EQ(facts(Module::kPath, 0) + facts(Module::kName, 0) + facts(Module::kCount, 0), "");
    ByteReader in(bytes.view(), "a catom");
    columns_->unpack(1, Columns::Which::All, in, 1);
    EXPECT_TRUE(in.done());
    EXPECT_EQ(facts(Module::kPath, 1) + facts(Module::kName, 1) + facts(Module::kCount, 1),
              R"(path(@1, [], "") path(@1, [1, 2], "first") name(@1, "zero") count(@1, -3) )");
    // What the bytes say depends on the content alone.
    ByteWriter again;
    columns_->pack(1, Columns::Which::All, again);
    EXPECT_EQ(again.take(), bytes.take());
    ByteWriter exported;
    columns_->pack(1, Columns::Which::Exported, exported);
    ByteReader from_exported(exported.view(), "exports");
    columns_->unpack(2, Columns::Which::Exported, from_exported, 0);
    EXPECT_EQ(facts(Module::kName, 2), "name(@2, \"zero\") ");
    for (u32 catom = 0; catom < 4; ++catom) columns_->clear(catom, 0);
    EXPECT_EQ(list_bytes(), 0u);
}

// A linear rule may hand a list from the facts it consumes to those it makes: the column that loses it is written first.
TEST_F(ColumnsWithLists, AListMayMoveFromOneColumnToAnother) {
    give(Module::kPath, 0, {"[1]", "handed on"});
    u8 record[16] = {};
    std::memcpy(record, columns_->rows(0, 0).data + 8, 8);
    record[8] = 1;
    const std::size_t before = list_bytes();
    columns_->set_rows(0, 0, nullptr, 0, 0);
    columns_->set_record(1, 0, record, 0);
    EXPECT_EQ(list_bytes(), before);
    columns_->release_dropped(0);
    EXPECT_LT(list_bytes(), before);
    EXPECT_EQ(facts(Module::kName, 0), "name(@0, \"handed on\") ");
}

TEST_F(ColumnsWithLists, RowsMayBeTheCatomsOwn) {
    give(Module::kPath, 0, {"[1]", "a"});
    give(Module::kPath, 0, {"[2]", "b"});
    const RowsHead& head = columns_->rows(0, 0);
    columns_->set_rows(0, 0, head.data + 16, 1, 0);
    columns_->release_dropped(0);
    EXPECT_EQ(facts(Module::kPath, 0), "path(@0, [2], \"b\") ");
}

TEST_F(ColumnsWithLists, NumbersAreGivenInPlace) {
    const auto give = [&](u32 predicate, const Numbers& numbers) { give_numbers(module_.info(), *columns_, predicate, 1, numbers, 1); };
    const auto read = [&](u32 predicate) { return read_numbers(module_.info(), *columns_, predicate, 1); };
    EXPECT_EQ(read(Module::kSpeed).count + read(Module::kTurn).count, 0u);
    give(Module::kTurn, {{1, -0.0}, 2});
    EXPECT_EQ(facts(Module::kSpeed, 1) + facts(Module::kTurn, 1), "turn(@1, 1.0, 0.0) ");
    give(Module::kSpeed, {{1, 2, 3}, 3});
    const std::size_t once = list_bytes();
    give(Module::kTurn, {{4, 5}, 2});
    give(Module::kSpeed, {{-0.0, 2.5, 3}, 3});
    EXPECT_EQ(facts(Module::kSpeed, 1) + facts(Module::kTurn, 1), "speed(@1, vec3(0.0, 2.5, 3.0)) turn(@1, 4.0, 5.0) ");
    EXPECT_EQ(read(Module::kSpeed).at, (std::array<double, 4>{0, 2.5, 3, 0}));
    EXPECT_EQ(read(Module::kTurn).count, 2u);
    EXPECT_EQ(list_bytes(), once);
    // What somebody else has kept stays as it was.
    columns_->set_record(3, 2, columns_->entry(3, 1), 0);
    give(Module::kSpeed, {{7, 8, 9}, 3});
    EXPECT_EQ(facts(Module::kSpeed, 1) + facts(Module::kSpeed, 2), "speed(@1, vec3(7.0, 8.0, 9.0)) speed(@2, vec3(0.0, 2.5, 3.0)) ");
    EXPECT_EQ(list_bytes(), 2 * once);
    for (const u32 catom : {1u, 2u}) columns_->clear(catom, 0);
    EXPECT_EQ(list_bytes(), 0u);
}

TEST_F(ColumnsWithLists, GrowingKeepsWhatIsThere) {
    give(Module::kName, 3, {"last"});
    columns_->resize(5000);
    give(Module::kName, 4999, {"later"});
    EXPECT_EQ(facts(Module::kName, 3) + facts(Module::kName, 4999), "name(@3, \"last\") name(@4999, \"later\") ");
    EXPECT_GE(columns_->bytes(), 5000u * (16 + 16 + 16) + list_bytes());
}

}  // namespace
}  // namespace meld::tuple
