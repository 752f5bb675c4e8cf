#include "runtime/world/shapes/shape.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "runtime/world/description/populate.h"
#include "runtime/world/shapes/shape_tree.h"

namespace meld::world {
namespace {

Shape shape(const std::string& text) {
    Result<Shape> parsed = Shape::parse(text);
    EXPECT_TRUE(parsed) << text << ": " << parsed.error().message();
    return parsed ? *parsed : Shape();
}

std::uint64_t cells(const std::string& text, LatticeKind kind = LatticeKind::Cubic) {
    World world;
    world.lattice = kind;
    world.body = shape(text);
    return count_catoms(world, Lattice(kind));
}

// As many as `expected` within a share.
void expect_near(std::uint64_t count, double expected, double share) {
    EXPECT_NEAR(static_cast<double>(count), expected, expected * share);
}

TEST(Shape, HoldsAsManyCellsAsABoxIsLong) {
    EXPECT_EQ(cells("box(22, 22, 22)"), 10'648u);
    EXPECT_EQ(cells("box(7, 1, 2)"), 14u);
    EXPECT_EQ(cells("move(box(10, 10, 10), 3, 4, 5)"), 1'000u);
    EXPECT_EQ(cells("rotate(box(10, 4, 2), z, 90)"), 80u);
    EXPECT_EQ(cells("box(10, 10, 1)", LatticeKind::Square), 100u);
}

TEST(Shape, HasTheVolumeOfItsFormula) {
    using std::numbers::pi;
    expect_near(cells("sphere(20)"), 4.0 / 3 * pi * 8000, 0.01);
    expect_near(cells("ellipsoid(30, 20, 10)"), 4.0 / 3 * pi * 6000, 0.01);
    expect_near(cells("torus(R=20, r=6)"), 2 * pi * pi * 20 * 36, 0.03);
    expect_near(cells("cylinder(r=20, h=50)"), pi * 400 * 50, 0.01);
    expect_near(cells("cone(r1=20, r2=5, h=30)"), pi * 30 / 3 * (400 + 100 + 25), 0.04);
    expect_near(cells("helix(r=20, pitch=20, turns=3, thickness=6)"), pi * 9 * 3 * std::hypot(2 * pi * 20, 20), 0.05);
    expect_near(cells("shell(sphere(20), 2)"), 4.0 / 3 * pi * (8000 - 5832), 0.03);
    expect_near(cells("scale(sphere(10), 2)"), 4.0 / 3 * pi * 8000, 0.01);
    expect_near(cells("sphere(20)", LatticeKind::Fcc), 4.0 / 3 * pi * 8000 * std::numbers::sqrt2, 0.01);
    expect_near(cells("sphere(50)", LatticeKind::Hex), pi * 2500 / (std::sqrt(3) / 2), 0.01);
}

TEST(Shape, CombinesAsSets) {
    EXPECT_EQ(cells("union(box(10,10,10), move(box(10,10,10), 5, 0, 0))"), 1'500u);
    EXPECT_EQ(cells("intersect(box(10,10,10), move(box(10,10,10), 5, 0, 0))"), 500u);
    EXPECT_EQ(cells("minus(box(10,10,10), box(4,4,4))"), 936u);
    EXPECT_EQ(cells("minus(box(10,10,10), box(4,4,4), box(2,2,10))"), 936u - 24u);
    EXPECT_EQ(cells("minus(box(10,10,10), box(10,10,10))"), 0u);
    EXPECT_FALSE(Shape().contains({0, 0, 0}));
    EXPECT_TRUE(Shape().bounds().empty());
    EXPECT_EQ(Shape::unite({shape("box(1,2,3)"), Shape(), shape("sphere( 4 )")}).text(), "union(box(1, 2, 3), sphere(4))");
}

const std::vector<std::string>& all_kinds() {
    static const std::vector<std::string> kTexts = {"box(9, 21, 14)",
                                                    "sphere(11.5)",
                                                    "ellipsoid(20, 5, 9)",
                                                    "torus(12, 4)",
                                                    "cylinder(7, 25)",
                                                    "cone(12, 0, 20)",
                                                    "cone(2, 11, 18)",
                                                    "helix(10, 12, 2.5, 5)",
                                                    "gyroid(40, 2)",
                                                    "gyroid(30, 1.5, period = 17)",
                                                    "trumpet(40)",
                                                    "trumpet(length=25, bell=15, wall=3)",
                                                    "campus(60)",
                                                    "union(sphere(8), move(box(6, 6, 30), 9, 2, 0))",
                                                    "intersect(sphere(12), box(30, 9, 30))",
                                                    "minus(sphere(13), cylinder(4, 40), box(40, 3, 3))",
                                                    "shell(sphere(14), 3)",
                                                    "shell(ellipsoid(18, 9, 12), 2)",
                                                    "rotate(box(20, 5, 9), y, 33)",
                                                    "scale(torus(5, 2), 2.5)"};
    return kTexts;
}

TEST(Shape, StaysWithinItsBounds) {
    std::mt19937 random(2);
    for (const std::string& text : all_kinds()) {
        const Shape s = shape(text);
        const Box box = s.bounds();
        std::uniform_real_distribution<double> coordinate(-70, 70);
        for (int i = 0; i < 20'000; ++i) {
            const Vec3 p = {coordinate(random), coordinate(random), coordinate(random)};
            if (!s.contains(p)) continue;
            for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_TRUE(p[axis] >= box.low[axis] && p[axis] <= box.high[axis]) << text;
        }
    }
}

TEST(Shape, NeverMisjudgesABox) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> coordinate(-25, 25), size(0, 9), unit(0, 1);
    for (const std::string& text : all_kinds()) {
        const Shape s = shape(text);
        int judged = 0;
        for (int i = 0; i < 3'000; ++i) {
            Box box;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                box.low[axis] = coordinate(random);
                box.high[axis] = box.low[axis] + size(random) * (i % 2 ? 0.3 : 1);
            }
            const bool outside = !s.may_touch(box), inside = s.surely_contains(box);
            judged += outside || inside;
            EXPECT_FALSE(outside && inside);
            for (int j = 0; j < 50; ++j) {
                Vec3 p;
                for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = std::lerp(box.low[axis], box.high[axis], unit(random));
                EXPECT_FALSE(outside && s.contains(p)) << text;
                EXPECT_FALSE(inside && !s.contains(p)) << text;
            }
        }
        EXPECT_GT(judged, 300) << text;
    }
}

// Many bodies are asked in groups, and answer as one after the other would.
TEST(Shape, UnitesManyPartsAsFew) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(-30, 30), size(0.5, 6);
    std::vector<Shape> parts;
    for (int i = 0; i < 500; ++i)
        parts.push_back(shape(fmt::format("move({}({}), {}, {}, {})", i % 2 ? "sphere" : "torus", i % 2 ? "r=2" : "4, 1", place(random),
                                          place(random), place(random))));
    parts.push_back(parts[7]);
    const Shape all = Shape::unite(parts);
    int held = 0, skipped = 0;
    for (int i = 0; i < 20'000; ++i) {
        const Vec3 p = {place(random), place(random), place(random)};
        const bool any = std::any_of(parts.begin(), parts.end(), [&](const Shape& part) { return part.contains(p); });
        ASSERT_EQ(all.contains(p), any);
        held += any;
        const double half = size(random) / 2;
        const Box box = {{p[0] - half, p[1] - half, p[2] - half}, {p[0] + half, p[1] + half, p[2] + half}};
        skipped += !all.may_touch(box);
        EXPECT_TRUE(all.may_touch(box) || !any);
    }
    EXPECT_GT(held, 1'000);
    EXPECT_GT(skipped, 100);
}

TEST(Shape, IsConnectedWhereItShouldBe) {
    for (const std::string text : {"trumpet(20)", "trumpet(90)", "trumpet(200)", "campus(100)", "helix(12, 14, 3, 5)"}) {
        for (const LatticeKind kind : {LatticeKind::Square, LatticeKind::Hex, LatticeKind::Cubic, LatticeKind::Fcc}) {
            const Lattice lattice(kind);
            if (lattice.flat() && !text.starts_with("trumpet")) continue;
            World world;
            world.body = shape(text);
            std::set<Cell> left;
            std::vector<std::uint32_t> numbers;
            for (const auto& [brick, count] : count_bricks(world, lattice, 0, 1)) {
                cells_of_brick(world, lattice, brick, numbers);
                for (const std::uint32_t number : numbers) left.insert(lattice.cell_in_brick(lattice.brick_at(brick), number));
            }
            ASSERT_FALSE(left.empty());
            std::vector<Cell> reached = {*left.begin()};
            left.erase(reached[0]);
            while (!reached.empty()) {
                const Cell cell = reached.back();
                reached.pop_back();
                for (int port = 0; port < lattice.ports(); ++port) {
                    const Cell there = lattice.neighbour(cell, port);
                    if (left.erase(there) > 0) reached.push_back(there);
                }
            }
            EXPECT_TRUE(left.empty()) << text << " on " << lattice.name() << ": " << left.size() << " cells left over";
        }
    }
}

TEST(Shape, HoldsTheOriginInTheStemOfATrumpet) {
    EXPECT_TRUE(shape("trumpet(length=90)").contains({0, 0, 0}));
    EXPECT_FALSE(shape("trumpet(length=90)").contains({80, 0, 0}));
    EXPECT_GT(cells("trumpet(length=100)"), 10'648u);
}

std::string shape_error(const std::string& text) {
    const Result<Shape> parsed = Shape::parse(text);
    return parsed ? "fine" : parsed.error().message();
}

TEST(Shape, SaysWhatIsWrongAndWhere) {
    EXPECT_EQ(shape_error("spere(r=3)"), "column 1: there is no shape 'spere'. did you mean 'sphere'?");
    EXPECT_EQ(shape_error("minus(box(1,2,3), shpere(4))"), "column 19: there is no shape 'shpere'. did you mean 'sphere'?");
    EXPECT_EQ(shape_error("box(1,2)"), "column 8: box lacks its argument z. write box(x, y, z)");
    EXPECT_EQ(shape_error("box(1,2,3,4)"), "column 11: box has 3 arguments, here is one more. write box(x, y, z)");
    EXPECT_EQ(shape_error("cylinder(radius=2, h=3)"), "column 10: cylinder has no argument 'radius'. one of r, h");
    EXPECT_EQ(shape_error("sphere(r=1, r=2)"), "column 13: argument r is given twice");
    EXPECT_EQ(shape_error("cylinder(r=1, 2)"), "column 15: an argument without a name follows one with a name. name it too");
    EXPECT_EQ(shape_error("sphere(-2)"), "column 8: r = -2 of sphere is not above zero");
    EXPECT_EQ(shape_error("sphere(0)"), "column 8: r = 0 of sphere is not above zero");
    EXPECT_EQ(shape_error("sphere(nan)"), "column 8: expected a number for r of sphere(r), found 'nan'");
    EXPECT_EQ(shape_error("sphere(1e999)"), "column 8: a number is too large or too small. use a length between 1e-300 and 1e300");
    EXPECT_EQ(shape_error("sphere(3x)"), "column 8: '3x' is not a number");
    EXPECT_EQ(shape_error("sphere(3"), "column 9: expected ',' or ')', found the end");
    EXPECT_EQ(shape_error("sphere(3) box(1,1,1)"), "column 11: expected nothing more, found 'box'");
    EXPECT_EQ(shape_error("sphere 3"), "column 8: expected '(' as in sphere(r), found '3'");
    EXPECT_EQ(shape_error(""), "column 1: expected a shape, found the end");
    EXPECT_EQ(shape_error("sphere(3)$"), "column 10: '$' cannot stand here");
    EXPECT_EQ(shape_error(std::string("sphere(\0)", 9)), "column 8: byte 0x00 cannot stand here");
    EXPECT_EQ(shape_error("rotate(box(1,1,1), w, 3)"), "column 20: expected an axis, x, y or z, found 'w'");
    EXPECT_EQ(shape_error("cone(0, 0, 3)"), "column 1: cone: r1 and r2 are both 0");
    EXPECT_EQ(shape_error("trumpet(9, bell=1)"), "column 1: trumpet: bell = 1 is less than wall = 2");
    EXPECT_EQ(shape_error("union()"), "column 7: union lacks its argument shape. write union(shape, ...)");
}

TEST(Shape, RefusesEndlessNesting) {
    std::string text;
    for (int i = 0; i < 100'000; ++i) text += "union(";
    EXPECT_EQ(shape_error(text), "column 1201: shapes are nested more than 200 deep");
}

}  // namespace
}  // namespace meld::world
