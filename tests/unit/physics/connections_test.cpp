// Groups of connected bodies against a slow reference that searches everything anew.
#include "physics/bodies/connections.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <tuple>
#include <vector>

namespace meld::physics {
namespace {

using Edges = std::set<std::pair<BodyId, BodyId>>;

// The groups of two or more, sorted.
std::set<std::vector<BodyId>> connected_groups(const Edges& edges) {
    std::map<BodyId, std::vector<BodyId>> neighbours;
    for (const auto& [a, b] : edges) neighbours[a].push_back(b), neighbours[b].push_back(a);
    std::set<BodyId> seen;
    std::set<std::vector<BodyId>> groups;
    for (const auto& [start, unused] : neighbours) {
        if (!seen.insert(start).second) continue;
        std::vector<BodyId> group{start};
        for (std::size_t i = 0; i < group.size(); ++i)
            for (const BodyId next : neighbours[group[i]])
                if (seen.insert(next).second) group.push_back(next);
        std::ranges::sort(group);
        groups.insert(group);
    }
    return groups;
}

TEST(Connections, AgreeWithASearchOfEverything) {
    for (const unsigned seed : {1u, 2u, 3u}) {
        std::mt19937 random(seed);
        // Few connections a body make many small groups, many one large group with loops.
        const BodyId bodies = 60;
        const std::size_t most = seed == 1 ? 30 : seed == 2 ? 60 : 150;
        Connections connections;
        Edges edges;
        std::set<std::vector<BodyId>> known;
        for (int round = 0; round < 300; ++round) {
            const std::set<std::vector<BodyId>> before = connected_groups(edges);
            for (unsigned changes = random() % 8; changes > 0; --changes) {
                auto a = BodyId(random() % bodies), b = BodyId(random() % bodies);
                if (random() % 40 == 0) {
                    connections.release_all(a);
                    std::erase_if(edges, [a](const auto& edge) { return edge.first == a || edge.second == a; });
                    continue;
                }
                if (a == b) continue;
                const auto edge = std::minmax(a, b);
                if (edges.size() < most && random() % 3 != 0) {
                    EXPECT_EQ(connections.connect(a, b), edges.insert(edge).second);
                } else {
                    if (!edges.empty() && random() % 2 == 0) std::tie(a, b) = *std::next(edges.begin(), long(random() % edges.size()));
                    EXPECT_EQ(connections.release(a, b), edges.erase(std::minmax(a, b)) == 1);
                }
            }
            const std::set<std::vector<BodyId>> now = connected_groups(edges);
            EXPECT_EQ(connections.count(), edges.size());
            const auto all = connections.all();
            EXPECT_EQ(Edges(all.begin(), all.end()), edges);
            const std::vector<std::vector<BodyId>> changed = connections.take_changed();
            const std::set<std::vector<BodyId>> reported(changed.begin(), changed.end());
            // Every new group is reported, and nothing that is no group.
            for (const auto& group : now) EXPECT_TRUE(before.contains(group) || reported.contains(group));
            for (const auto& group : reported) EXPECT_TRUE(now.contains(group));
            std::map<BodyId, const std::vector<BodyId>*> group_of;
            for (const auto& group : now)
                for (const BodyId body : group) group_of[body] = &group;
            for (BodyId a = 0; a < bodies; ++a)
                for (BodyId b = 0; b < a; ++b)
                    ASSERT_EQ(connections.together(a, b), group_of.contains(a) && group_of.contains(b) && group_of[a] == group_of[b]);
        }
    }
}

TEST(Connections, GroupsDoNotDependOnTheOrderOfChanges) {
    std::vector<std::pair<BodyId, BodyId>> pairs;
    for (BodyId i = 0; i + 1 < 100; ++i) pairs.emplace_back(i, i + 1);
    std::mt19937 random(7);
    std::vector<std::vector<std::vector<BodyId>>> results;
    for (int order = 0; order < 4; ++order) {
        std::shuffle(pairs.begin(), pairs.end(), random);
        Connections connections;
        for (const auto& [a, b] : pairs) connections.connect(a, b);
        for (const auto& [a, b] : pairs)
            if (a % 10 == 9) connections.release(b, a);
        results.push_back(connections.take_changed());
    }
    EXPECT_EQ(results[0].size(), 10u);
    for (const auto& result : results) EXPECT_EQ(result, results[0]);
}

}  // namespace
}  // namespace meld::physics
