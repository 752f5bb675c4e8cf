#include "runtime/world/graph/graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "runtime/world/graph/divide.h"
#include "runtime/world/graph/generate.h"
#include "runtime/world/graph/layout.h"

namespace meld::graph {
namespace {

std::vector<Node> row(const Graph& graph, Node node) {
    const auto all = graph.neighbours(node);
    return {all.begin(), all.end()};
}

Column weights(std::vector<std::int64_t> values) { return {.name = "weight", .values = std::move(values)}; }

TEST(Graph, LoopsAreLeftOutAndDoubledLinksCountOnce) {
    const Made made = make(4, {{2, 1}, {0, 1}, {1, 2}, {3, 3}, {0, 1}});
    EXPECT_EQ(row(made.graph, 1), (std::vector<Node>{0, 2}));
    EXPECT_EQ(row(made.graph, 3), std::vector<Node>());
    EXPECT_EQ(made.graph.links(), 2u);
    EXPECT_EQ(made.loops, 1u);
    EXPECT_EQ(made.first_loop, 3u);
    EXPECT_EQ(made.doubled, 2u);
}

TEST(Graph, AnUndirectedLinkHasItsRowInBothDirections) {
    const Graph graph = make(3, {{2, 0}, {0, 1}}, false, {weights({7, 9})}).graph;
    ASSERT_EQ(graph.to, (std::vector<Node>{1, 2, 0, 0}));
    EXPECT_EQ(graph.row, (std::vector<Row>{1, 0, 1, 0}));
}

TEST(Graph, ADirectedLinkLeadsOneWay) {
    const Graph graph = make(3, {{2, 0}, {0, 1}, {1, 0}}, true, {weights({7, 9, 8})}).graph;
    ASSERT_EQ(graph.to, (std::vector<Node>{1, 2, 0, 0}));
    EXPECT_EQ(graph.row, (std::vector<Row>{1, kNoRow, 2, 0}));
    EXPECT_TRUE(graph.leads(0));
    EXPECT_FALSE(graph.leads(1));
}

TEST(Graph, ALinkWithTwoWeightsIsAConflict) {
    const Made made = make(3, {{0, 1}, {1, 2}, {1, 0}}, false, {weights({1, 1, 2})});
    ASSERT_TRUE(made.conflict.has_value());
    EXPECT_EQ(made.conflict->first, 0u);
    EXPECT_EQ(made.conflict->second, 2u);
    EXPECT_FALSE(make(3, {{0, 1}, {1, 2}, {1, 0}}, true, {weights({1, 1, 2})}).conflict.has_value());
    const Made same = make(3, {{0, 1}, {1, 2}, {1, 0}}, false, {weights({1, 1, 1})});
    EXPECT_FALSE(same.conflict.has_value());
    EXPECT_EQ(same.doubled, 1u);
    EXPECT_EQ(same.first_doubled, 2u);
}

TEST(Graph, ComponentsAndDegrees) {
    const Graph graph = make(6, {{0, 1}, {1, 2}, {4, 5}}).graph;
    EXPECT_EQ(components(graph), 3u);
    EXPECT_EQ(degrees(graph).least, 0u);
    EXPECT_EQ(degrees(graph).most, 2u);
    EXPECT_DOUBLE_EQ(degrees(graph).mean, 1);
}

TEST(Graph, PartsAreOfAboutTheSameWeightAndCutFewLinks) {
    const Graph grid = *generate("grid(40, 40)", 1);
    for (const int parts : {2, 3, 4}) {
        const std::vector<std::int32_t> part = divide(grid, parts);
        EXPECT_EQ(part, divide(grid, parts));
        std::vector<double> weight(static_cast<std::size_t>(parts));
        for (Node n = 0; n < grid.nodes(); ++n) weight[static_cast<std::size_t>(part[n])] += 1 + static_cast<double>(grid.degree(n));
        const auto [least, most] = std::minmax_element(weight.begin(), weight.end());
        EXPECT_LT(*most / *least, 1.15);
        // Straight cuts would be of 40 links each.
        EXPECT_LE(cut(grid, part), 60u * static_cast<unsigned>(parts - 1));
        EXPECT_GE(cut(grid, part), 40u);
    }
}

TEST(Graph, SmallGraphsCanBeDividedToo) {
    for (const char* text : {"ring(1)", "ring(3)", "random(20, 0)", "star(30)"})
        for (const int parts : {1, 2, 4})
            for (const std::int32_t part : divide(*generate(text, 1), parts)) EXPECT_TRUE(part >= 0 && part < parts) << text;
}

TEST(Graph, APictureOfAGridLooksLikeOne) {
    Graph grid = *generate("grid(12, 12)", 1);
    const std::vector<Point> places = by_distances(grid);
    const auto apart = [&](Node a, Node b) { return std::hypot(places[a][0] - places[b][0], places[a][1] - places[b][1]); };
    // Opposite corners are far apart, neighbours near.
    EXPECT_GT(std::min(apart(0, 143), apart(11, 132)), 15);
    double linked = 0;
    for (Node n = 0; n < grid.nodes(); ++n)
        for (const Node other : grid.neighbours(n)) linked += apart(n, other) / static_cast<double>(grid.to.size());
    EXPECT_LT(linked, 4);
    EXPECT_EQ(places, by_distances(grid));
}

TEST(Graph, ComponentsDoNotOverlapInPictures) {
    const Graph two = make(8, {{0, 1}, {1, 2}, {2, 3}, {4, 5}, {5, 6}, {6, 7}}).graph;
    const std::vector<Point> places = by_distances(two);
    double low[2] = {1e9, 1e9}, high[2] = {-1e9, -1e9};
    double top[2] = {-1e9, -1e9}, bottom[2] = {1e9, 1e9};
    for (std::size_t i = 0; i < 8; ++i) {
        low[i / 4] = std::min(low[i / 4], places[i][0]), high[i / 4] = std::max(high[i / 4], places[i][0]);
        bottom[i / 4] = std::min(bottom[i / 4], places[i][1]), top[i / 4] = std::max(top[i / 4], places[i][1]);
    }
    EXPECT_TRUE(high[0] < low[1] || bottom[0] > top[1]);
}

}  // namespace
}  // namespace meld::graph
