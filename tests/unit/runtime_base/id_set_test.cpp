#include "runtime/base/id_set.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <vector>

namespace meld {
namespace {

struct Thing;
using ThingId = Id<Thing>;
using Things = IdSet<Thing>;

TEST(IdSet, IsASetOfIdsInTheirOrder) {
    std::mt19937 random(1);
    for (const std::size_t greatest : {5, 63, 64, 65, 400}) {
        Things set;
        std::set<ThingId> expected;
        for (int i = 0; i < 300; ++i) {
            const ThingId id(random() % (greatest + 1));
            EXPECT_EQ(set.contains(id), expected.contains(id));
            if (random() % 3 == 0) {
                set.erase(id), expected.erase(id);
            } else {
                EXPECT_EQ(set.insert(id), expected.insert(id).second);
            }
            ASSERT_EQ(std::vector(set.begin(), set.end()), std::vector(expected.begin(), expected.end()));
            EXPECT_EQ(set.size(), expected.size());
            EXPECT_EQ(set.empty(), expected.empty());
        }
        const Things same(expected.begin(), expected.end());
        EXPECT_EQ(std::vector(same.begin(), same.end()), std::vector(set.begin(), set.end()));
        set.clear();
        EXPECT_TRUE(set.empty() && set.begin() == set.end());
    }
}

TEST(IdSet, HasNoIdsThatAreNotValid) {
    Things set{ThingId(3), ThingId(), ThingId(70)};
    EXPECT_FALSE(set.insert(ThingId()));
    EXPECT_FALSE(set.contains(ThingId()));
    EXPECT_EQ(set.size(), 2U);
    set.erase(ThingId());
    set.erase(ThingId(1000));
    EXPECT_EQ(set.size(), 2U);
}

}  // namespace
}  // namespace meld
