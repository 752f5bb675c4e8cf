#include "runtime/world/graph/range.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "runtime/world/graph/draws.h"
#include "runtime/world/graph/generate.h"

namespace meld::graph {
namespace {

using Pairs = std::set<std::pair<Node, Node>>;

Pairs all_pairs(const std::vector<Point>& places, double range) {
    Pairs out;
    for (Node a = 0; a < places.size(); ++a)
        for (Node b = 0; b < places.size(); ++b)
            if (a != b && square_distance(places[a], places[b]) <= range * range) out.emplace(a, b);
    return out;
}

Pairs found(const PointGrid& grid, const std::vector<Point>& places) {
    Pairs out;
    for (Node node = 0; node < places.size(); ++node)
        grid.each_within(node, places, [&](Node other) { EXPECT_TRUE(out.emplace(node, other).second) << node << " " << other; });
    return out;
}

TEST(PointGrid, FindsEachPairInRangeOnce) {
    // Points on the corners of cells, among others, and far outside.
    for (const double range : {1.0, 0.3, 2.5, 1e-3, 1e5}) {
        Draws draws(7, 0);
        std::vector<Point> places;
        for (int i = 0; i < 200; ++i) {
            Point at{};
            for (double& x : at) x = i % 2 == 0 ? 4 * draws.unit() - 2 : static_cast<double>(draws.below(9)) * range - 4 * range;
            places.push_back(at);
        }
        places.push_back({1e300, 0, 0}), places.push_back({1e300, range, 0}), places.push_back({-1e300, 0, 0});
        PointGrid grid(range);
        for (Node node = 0; node < places.size(); ++node) grid.add(node, places[node]);
        EXPECT_EQ(found(grid, places), all_pairs(places, range)) << range;
    }
}

TEST(PointGrid, FollowsPointsThatMoveAndGo) {
    Draws draws(3, 0);
    std::vector<Point> places(60);
    PointGrid grid(1.0);
    for (Node node = 0; node < places.size(); ++node) grid.add(node, places[node]);
    for (int turn = 0; turn < 300; ++turn) {
        const auto node = static_cast<Node>(draws.below(places.size()));
        Point to = places[node];
        for (double& x : to) x += 2 * draws.unit() - 1;
        grid.move(node, places[node], to);
        places[node] = to;
        if (turn % 10 == 0) {
            EXPECT_EQ(found(grid, places), all_pairs(places, 1.0)) << turn;
        }
    }
    while (!places.empty()) {
        grid.remove(static_cast<Node>(places.size() - 1), places.back());
        places.pop_back();
        EXPECT_EQ(found(grid, places), all_pairs(places, 1.0));
    }
    EXPECT_EQ(grid.candidates(), 0);
}

TEST(LinkWithin, LinksWhatIsInRange) {
    for (const char* text : {"scatter(300, 20, 20)", "scatter(200, 8, 8, 8)", "disc(250, 9)", "ball(250, 5)", "disc(1, 0)"}) {
        Graph graph = *generate(text, 2);
        ASSERT_TRUE(link_within(graph, 2.0, text, {}).has_value());
        Pairs linked;
        for (Node node = 0; node < graph.nodes(); ++node) {
            const auto row = graph.neighbours(node);
            EXPECT_TRUE(std::ranges::is_sorted(row));
            for (const Node other : row) linked.emplace(node, other);
        }
        EXPECT_EQ(linked, all_pairs(graph.places, 2.0)) << text;
    }
}

TEST(LinkWithin, RefusesWhatDoesNotFitIntoMemory) {
    Graph graph = *generate("disc(20000, 10)", 1);
    const auto small = link_within(graph, 5.0, "disc(20000, 10)", {.bytes = 1 << 20, .text = "there is 1 MiB"});
    ASSERT_FALSE(small.has_value());
    EXPECT_EQ(small.error().code, ExitCode::LimitHit);
    Graph dense = *generate("disc(200000, 10)", 1);
    const auto many = link_within(dense, 20.0, "disc(200000, 10)", {});
    ASSERT_FALSE(many.has_value());
    EXPECT_NE(many.error().problem.find("a graph has at most 2e+09"), std::string::npos) << many.error().problem;
}

TEST(Generate, PointsFillTheirShapesEvenly) {
    const auto count = [](const char* text, const auto& in) {
        const Graph graph = *generate(text, 9);
        EXPECT_EQ(graph.links(), 0U);
        return static_cast<double>(std::ranges::count_if(graph.places, in));
    };
    const auto radius = [](const Point& at) { return std::sqrt(square_distance({}, at)); };
    // Of 20,000 points, within five standard deviations.
    EXPECT_NEAR(count("disc(20000, 7)", [&](const Point& at) { return radius(at) < 3.5; }), 5000, 310);
    EXPECT_EQ(count("disc(20000, 7)", [&](const Point& at) { return radius(at) > 7 || at[2] != 0; }), 0);
    EXPECT_NEAR(count("ball(20000, 7)", [&](const Point& at) { return radius(at) < 3.5; }), 2500, 235);
    EXPECT_EQ(count("ball(20000, 7)", [&](const Point& at) { return radius(at) > 7; }), 0);
    EXPECT_NEAR(count("ball(20000, 7)", [&](const Point& at) { return at[2] > 0; }), 10000, 355);
    EXPECT_NEAR(count("scatter(20000, 4, 2, 1)", [](const Point& at) { return at[0] < 0 && at[1] > 0.5 && at[2] > 0; }), 1250, 175);
    EXPECT_EQ(count("scatter(20000, 4, 2)", [](const Point& at) { return std::abs(at[0]) > 2 || std::abs(at[1]) > 1 || at[2] != 0; }), 0);
}

}  // namespace
}  // namespace meld::graph
