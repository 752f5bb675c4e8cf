#include "runtime/world/graph/generate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace meld::graph {
namespace {

Graph made(const std::string& text, std::uint64_t seed = 1) {
    Result<Graph> graph = generate(text, seed);
    EXPECT_TRUE(graph.has_value()) << (graph ? "" : graph.error().message());
    return graph ? std::move(*graph) : Graph();
}

std::map<std::uint64_t, int> degree_counts(const Graph& graph) {
    std::map<std::uint64_t, int> out;
    for (Node n = 0; n < graph.nodes(); ++n) ++out[graph.degree(n)];
    return out;
}

// Rows ascend, without the node itself, and each link is seen from both ends.
void expect_simple(const Graph& graph, const std::string& text) {
    std::set<std::pair<Node, Node>> links;
    for (Node n = 0; n < graph.nodes(); ++n) {
        const auto row = graph.neighbours(n);
        EXPECT_TRUE(std::is_sorted(row.begin(), row.end())) << text;
        EXPECT_EQ(std::adjacent_find(row.begin(), row.end()), row.end()) << text;
        for (const Node other : row) {
            EXPECT_NE(other, n) << text;
            links.emplace(n, other);
        }
    }
    for (const auto& [a, b] : links) EXPECT_TRUE(links.contains({b, a})) << text << ": " << a << " " << b;
}

TEST(Generate, RegularGraphsHaveTheirDegrees) {
    using Counts = std::map<std::uint64_t, int>;
    const std::pair<const char*, Counts> expected[] = {
        {"line(5)", {{1, 2}, {2, 3}}},
        {"ring(7)", {{2, 7}}},
        {"ring(2)", {{1, 2}}},
        {"ring(1)", {{0, 1}}},
        {"star(6)", {{1, 5}, {5, 1}}},
        {"complete(5)", {{4, 5}}},
        {"grid(3, 4)", {{2, 4}, {3, 6}, {4, 2}}},
        {"grid(2,2,2)", {{3, 8}}},
        {"torus(3, 4)", {{4, 12}}},
        {"torus(2, 4)", {{3, 8}}},
        {"torus(3,3,3)", {{6, 27}}},
        {"hypercube(4)", {{4, 16}}},
        {"tree(7, 2)", {{1, 4}, {2, 1}, {3, 2}}},
        {"regular(10, 3)", {{3, 10}}},
        {"regular(9, 6)", {{6, 9}}},
        {"regular(6, 5)", {{5, 6}}},
        {"regular(4, 0)", {{0, 4}}},
        {"small_world(20, 4, 0)", {{4, 20}}},
        {"small_world(5, 4, 1)", {{4, 5}}},
        {"random(6, 1)", {{5, 6}}},
        {"random(6, 0)", {{0, 6}}},
        {"geometric(4, 2)", {{3, 4}}},
    };
    for (const auto& [text, counts] : expected) {
        const Graph graph = made(text);
        EXPECT_EQ(degree_counts(graph), counts) << text;
        expect_simple(graph, text);
    }
}

TEST(Generate, ATreeLinksChildrenWithParents) {
    const Graph tree = made("tree(10, 3)");
    for (Node child = 1; child < 10; ++child) EXPECT_EQ(tree.neighbours(child)[0], (child - 1) / 3);
}

TEST(Generate, RandomGraphsHaveTheExpectedNumberOfLinks) {
    const Graph random = made("random(2000, 0.01)");
    // 19990 expected, with a standard deviation of 141.
    EXPECT_NEAR(static_cast<double>(random.links()), 19990, 700);
    expect_simple(random, "random");
    EXPECT_EQ(made("scale_free(1000, 3)").links(), 3u * 997);
    EXPECT_EQ(made("small_world(1000, 6, 0.3)").links(), 3000u);
    EXPECT_EQ(made("regular(1000, 7)").links(), 3500u);
    for (const char* text : {"scale_free(1000, 3)", "small_world(1000, 6, 0.3)", "small_world(100, 20, 1)", "regular(1000, 7)",
                             "regular(50, 24)", "geometric(500, 0.08)", "random(50, 0.9)"})
        expect_simple(made(text), text);
    for (const std::uint64_t seed : {1, 2, 3})
        EXPECT_EQ(degree_counts(made("regular(20, 3)", seed)), (std::map<std::uint64_t, int>{{3, 20}}));
}

TEST(Generate, EveryPairOfARandomGraphIsEquallyLikely) {
    std::map<std::pair<Node, Node>, int> seen;
    for (std::uint64_t seed = 0; seed < 2000; ++seed) {
        const Graph graph = made("random(5, 0.3)", seed);
        for (Node n = 0; n < 5; ++n)
            for (const Node other : graph.neighbours(n))
                if (n < other) ++seen[{n, other}];
    }
    ASSERT_EQ(seen.size(), 10u);
    // 600 expected, with a standard deviation of 20.
    for (const auto& [pair, count] : seen) EXPECT_NEAR(count, 600, 100) << pair.first << " " << pair.second;
}

TEST(Generate, AGeometricGraphLinksExactlyTheNearPoints) {
    const Graph graph = made("geometric(300, 0.1)");
    // Places are those of the unit square, enlarged.
    const double side = 2 * std::sqrt(300.0);
    int links = 0;
    for (Node a = 0; a < 300; ++a)
        for (Node b = 0; b < 300; ++b) {
            if (a == b) continue;
            const double dx = (graph.places[a][0] - graph.places[b][0]) / side, dy = (graph.places[a][1] - graph.places[b][1]) / side;
            const auto row = graph.neighbours(a);
            const bool linked = std::binary_search(row.begin(), row.end(), b);
            // Not at the border, where the scale may round.
            const bool at_border = std::abs(dx * dx + dy * dy - 0.01) < 1e-9;
            EXPECT_TRUE(at_border || linked == (dx * dx + dy * dy < 0.01)) << a << " " << b;
            links += linked ? 1 : 0;
        }
    EXPECT_EQ(static_cast<std::uint64_t>(links), 2 * graph.links());
    EXPECT_GT(links, 1000);
}

TEST(Generate, AScaleFreeGraphHasHubsAndIsConnected) {
    const Graph graph = made("scale_free(20000, 4)");
    EXPECT_EQ(components(graph), 1u);
    const Degrees all = degrees(graph);
    EXPECT_GE(all.least, 1u);
    EXPECT_GT(all.most, 200u);
    // The number of nodes with at least k links falls as k^-2.
    const auto at_least = [&](std::uint64_t k) {
        double count = 0;
        for (Node n = 0; n < graph.nodes(); ++n) count += graph.degree(n) >= k ? 1 : 0;
        return count;
    };
    EXPECT_NEAR(at_least(16) / at_least(32), 4, 0.8);
}

TEST(Generate, RewiringShortensASmallWorld) {
    EXPECT_EQ(components(made("small_world(1000, 4, 0.1)")), 1u);
    int far = 0;
    const Graph graph = made("small_world(1000, 4, 0.1)");
    for (Node n = 0; n < 1000; ++n)
        for (const Node other : graph.neighbours(n)) {
            const int apart = std::abs(static_cast<int>(n) - static_cast<int>(other));
            far += n < other && std::min(apart, 1000 - apart) > 2 ? 1 : 0;
        }
    // 2000 links, a tenth of them anywhere.
    EXPECT_NEAR(far, 200, 60);
}

TEST(Generate, ASeedDecidesTheGraph) {
    for (const char* text :
         {"random(500, 0.02)", "regular(100, 4)", "geometric(200, 0.1)", "scale_free(300, 2)", "small_world(100, 4, 0.5)"}) {
        EXPECT_EQ(made(text, 7).hash(), made(text, 7).hash()) << text;
        EXPECT_NE(made(text, 7).hash(), made(text, 8).hash()) << text;
    }
}

TEST(Generate, AMillionNodesTakeSeconds) {
    const Graph graph = made("scale_free(1M, 8)");
    EXPECT_EQ(graph.nodes(), 1'000'000u);
    EXPECT_EQ(graph.links(), 8u * 999'992);
    EXPECT_TRUE(graph.row.empty());
}

TEST(Generate, MistakesAreNamed) {
    const std::pair<const char*, const char*> wrong[] = {
        {"rng(5)", "there is no graph 'rng'. did you mean 'ring'?"},
        {"ring", "has no arguments in parentheses. write ring(n)"},
        {"ring(5, 6)", "ring has 1 argument, here are 2. write ring(n)"},
        {"grid(5)", "grid has 2 arguments, here are 1. write grid(w, h)"},
        {"ring(0)", "0 is not a whole number of at least 1 in ring(0)"},
        {"ring(2.5)", "2.5 is not a whole number"},
        {"ring(x)", "'x'"},
        {"random(10, 1.5)", "1.5 is no probability in random(10, 1.5)"},
        {"random(10, -1)", "-1 is below 0"},
        {"regular(5, 3)", "every link has two ends. make one of the two even"},
        {"regular(4, 4)", "no node of 4 has 4 neighbours"},
        {"scale_free(5, 5)", "cannot have 5 links with earlier ones"},
        {"small_world(10, 3, 0.1)", "make k even and less than n"},
        {"tree(5, 0)", "make k at least 1"},
        {"torus(0, 3)", "0 is not a whole number of at least 1"},
        {"torus(3, 0)", "a side of torus(3, 0) has no nodes"},
        {"complete(1M)", "a graph has at most"},
        {"hypercube(40)", "a graph has at most"},
    };
    for (const auto& [text, message] : wrong) {
        const Result<Graph> graph = generate(text, 1);
        ASSERT_FALSE(graph.has_value()) << text;
        EXPECT_NE(graph.error().message().find(message), std::string::npos) << text << ": " << graph.error().message();
    }
}

}  // namespace
}  // namespace meld::graph
