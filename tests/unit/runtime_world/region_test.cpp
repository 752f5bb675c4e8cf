#include <gtest/gtest.h>

#include "runtime/world/shapes/region_id.h"
#include "runtime/world/shapes/shape.h"

namespace meld::world {
namespace {

bool holds(const std::string& text, std::uint64_t id, Cell cell) {
    const Result<Region> region = Region::parse(text);
    EXPECT_TRUE(region) << text << ": " << region.error().message();
    return region && region->contains(id, cell, {static_cast<double>(cell.x), static_cast<double>(cell.y), static_cast<double>(cell.z)});
}

std::string region_error(const std::string& text) {
    const Result<Region> region = Region::parse(text);
    return region ? "fine" : region.error().message();
}

TEST(Region, PicksCatomsByIdCellAndPlace) {
    EXPECT_TRUE(Region().contains(3, {}, {}));
    EXPECT_TRUE(holds("all", 3, {}));
    EXPECT_TRUE(holds("id == 4", 4, {}));
    EXPECT_FALSE(holds("id == 4", 5, {}));
    EXPECT_TRUE(holds("cell == (0,-1,2)", 5, {0, -1, 2}));
    EXPECT_FALSE(holds("cell != (0,-1,2)", 5, {0, -1, 2}));
    EXPECT_TRUE(holds("x > 3 && z == 0", 0, {4, 9, 0}));
    EXPECT_FALSE(holds("x > 3 && z == 0", 0, {4, 9, 1}));
    EXPECT_TRUE(holds("x >= -3", 0, {-3, 0, 0}));
    EXPECT_TRUE(holds("inside(sphere(r=4))", 0, {0, 0, 4}));
    EXPECT_FALSE(holds("inside(sphere(r=4))", 0, {1, 0, 4}));
    EXPECT_TRUE(holds("x % 4 == 3", 0, {-1, 0, 0}));
}

TEST(Region, BindsAndMoreTightlyThanOr) {
    EXPECT_TRUE(holds("id == 1 || id == 2 && x == 9", 1, {}));
    EXPECT_FALSE(holds("(id == 1 || id == 2) && x == 9", 1, {}));
    EXPECT_TRUE(holds("!(id == 1) && !inside(box(2, 2, 2))", 2, {5, 0, 0}));
}

TEST(Region, SaysWhatIsWrongAndWhere) {
    EXPECT_EQ(region_error("id = 4"), "column 4: expected a comparison, == != < <= > or >=, found '='. write ==");
    EXPECT_EQ(region_error("id 4"), "column 4: expected a comparison, == != < <= > or >=, found '4'");
    EXPECT_EQ(region_error("cel == (0,0,0)"), "column 1: nothing is called 'cel' here. did you mean 'cell'?");
    EXPECT_EQ(region_error("cell == (0,0)"), "column 13: expected ',', found ')'");
    EXPECT_EQ(region_error("cell == (0,0,0.5)"), "column 14: 0.5 is not an integer");
    EXPECT_EQ(region_error("cell == (0,0,9999999)"), "column 14: coordinate 9999999 is not between -1048576 and 1048575");
    EXPECT_EQ(region_error("id == 4 id == 5"), "column 9: expected '&&', '||' or nothing more, found 'id'");
    EXPECT_EQ(region_error("x > 3 &&"), "column 9: expected a test such as id == 4, cell == (0, 0, 0) or inside(sphere(4)), found the end");
    EXPECT_EQ(region_error("inside(spher(3))"), "column 8: there is no shape 'spher'. did you mean 'sphere'?");
    EXPECT_EQ(region_error("x % 0 == 1"), "column 5: the number after '%' must be above zero");
    EXPECT_EQ(region_error(std::string(300, '!')), "column 201: regions are nested more than 200 deep");
}

TEST(Region, IsKnownToBeOneCatomIfItIsWrittenSo) {
    const auto named = [](const std::string& text) { return named_id(*Region::parse(text)); };
    EXPECT_EQ(named("id == 4"), std::optional<std::uint64_t>(4));
    EXPECT_EQ(named(" id==0 "), std::optional<std::uint64_t>(0));
    for (const char* text : {"all", "id == -1", "id == 1.5", "id % 3 == 1", "id <= 4", "x == 4", "id == 4 || id == 5", "!(id == 4)"})
        EXPECT_EQ(named(text), std::nullopt) << text;
}

}  // namespace
}  // namespace meld::world
