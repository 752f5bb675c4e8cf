// Tombstones beside the simplest thing that remembers the same: losses by catom, in the order in which they came.
#include "runtime/engine/eval/tombstones.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <vector>

namespace meld::eval {
namespace {

using Entry = Tombstones::Entry;
using Losses = std::map<u32, std::vector<Entry>>;

bool same(const std::vector<Entry>& a, const std::vector<Entry>& b) {
    return std::ranges::equal(a, b, [](const Entry& x, const Entry& y) {
        return x.predicate == y.predicate && x.least_rank == y.least_rank && x.key == y.key && x.time == y.time;
    });
}

void expect_same(const Tombstones& tombstones, const Losses& losses, u32 catoms) {
    EXPECT_EQ(tombstones.count(), losses.size());
    EXPECT_EQ(tombstones.empty(), losses.empty());
    std::size_t seen = 0;
    tombstones.each([&](u32 catom, const std::vector<Entry>& entries) {
        ++seen;
        ASSERT_TRUE(losses.contains(catom)) << catom;
        EXPECT_TRUE(same(entries, losses.at(catom))) << catom;
    });
    EXPECT_EQ(seen, losses.size());
    for (u32 catom = 0; catom < catoms; ++catom) EXPECT_EQ(tombstones.has(catom), losses.contains(catom)) << catom;
}

TEST(Tombstones, RememberWhatALongListDoes) {
    std::mt19937 draw(7);
    const auto below = [&](u32 n) { return static_cast<u32>(draw() % n); };
    for (int world = 0; world < 20; ++world) {
        // Dense blocks, strides that would meet in a table of a power of two, and catoms by chance.
        const u32 stride = world % 3 == 0 ? 1 : world % 3 == 1 ? 4096 : 7919;
        const u32 catoms = 1 + below(400), greatest = 50;
        Tombstones tombstones;
        Losses losses;
        for (i64 now = 1; now < 200; ++now) {
            for (u32 i = below(40); i > 0; --i) {
                const u32 catom = below(catoms) * stride, rank = below(greatest);
                const auto predicate = static_cast<u16>(below(2));
                const u64 key = below(3);
                tombstones.lose(catom, predicate, key, rank, now, greatest, 1);
                std::vector<Entry>& list = losses[catom];
                const auto known = std::ranges::find_if(list, [&](const Entry& e) { return e.predicate == predicate && e.key == key; });
                if (known == list.end()) {
                    list.push_back({predicate, rank, key, now});
                } else {
                    const bool expired = Tombstones::expired(*known, now, greatest, 1);
                    *known = {predicate, expired ? rank : std::min(known->least_rank, rank), key, now};
                }
            }
            if (below(10) == 0) {
                const u32 catom = below(catoms) * stride;
                tombstones.forget(catom);
                losses.erase(catom);
                if (below(2) == 0) {
                    tombstones.restore(catom, {{1, 5, 9, now}, {0, 6, 9, now}});
                    losses[catom] = {{1, 5, 9, now}, {0, 6, 9, now}};
                }
            }
            if (now % 16 == 0) {
                tombstones.sweep(now, greatest, 1);
                for (auto& [catom, list] : losses)
                    std::erase_if(list, [&](const Entry& e) { return Tombstones::expired(e, now, greatest, 1); });
                std::erase_if(losses, [](const auto& each) { return each.second.empty(); });
            }
            const u32 catom = below(catoms) * stride;
            const Entry* found = tombstones.find(catom, 0, 1);
            const auto list = losses.find(catom);
            const bool there =
                list != losses.end() && std::ranges::any_of(list->second, [](const Entry& e) { return e.predicate == 0 && e.key == 1; });
            ASSERT_EQ(found != nullptr, there);
        }
        expect_same(tombstones, losses, stride == 1 ? catoms : 0);
        tombstones.sweep(1000, greatest, 1);
        expect_same(tombstones, {}, 100);
    }
}

}  // namespace
}  // namespace meld::eval
