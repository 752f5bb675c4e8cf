#include "runtime/world/ensemble/links.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <utility>

namespace meld::world {
namespace {

// What the table should hold: for each catom and port, the neighbour and its port.
using Plain = std::map<std::pair<Catom, Port>, std::pair<Catom, Port>>;

void expect_alike(const Links& links, const Plain& plain, Catom catoms) {
    Geometry g;
    links.add_to(g);
    std::size_t found = 0;
    for (Catom c = 0; c < catoms; ++c)
        each_link(g, c, [&](i32 port, u32 other) {
            ++found;
            const auto at = plain.find({c, static_cast<Port>(port)});
            ASSERT_NE(at, plain.end()) << c << " " << port;
            EXPECT_EQ(at->second.first, other);
            EXPECT_EQ(static_cast<i32>(at->second.second), port_there(g, c, port));
            EXPECT_EQ(links.towards(c, other).has_value(), true);
        });
    EXPECT_EQ(found, plain.size());
}

TEST(Links, FollowARandomHistoryWhileRowsGrowAndAreWrittenAnew) {
    std::mt19937 random(7);
    constexpr Catom kCatoms = 40;
    Links links(false);
    Plain plain;
    for (Catom c = 0; c < kCatoms; ++c) links.room(c, 0);
    const auto port_for = [&](Catom c) {
        if (const auto vacant = links.vacant(c)) return *vacant;
        const Port had = links.ports(c);
        links.room(c, static_cast<Port>(had + 1 + had / 2));
        return had;
    };
    for (int step = 0; step < 5000; ++step) {
        const auto a = static_cast<Catom>(random() % kCatoms), b = static_cast<Catom>(random() % kCatoms);
        switch (random() % 8) {
            case 0: {
                links.clear(a);
                std::erase_if(plain, [&](const auto& link) { return link.first.first == a || link.second.first == a; });
                break;
            }
            case 1:
            case 2: {
                const auto port = links.towards(a, b);
                if (!port) break;
                plain.erase({b, links.port_there(a, *port)});
                plain.erase({a, *port});
                links.disconnect(a, *port);
                break;
            }
            default: {
                if (a == b || links.towards(a, b)) break;
                const Port pa = port_for(a), pb = port_for(b);
                links.connect(a, pa, b, pb);
                plain[{a, pa}] = {b, pb};
                plain[{b, pb}] = {a, pa};
            }
        }
        if (step % 100 == 0) expect_alike(links, plain, kCatoms);
    }
    expect_alike(links, plain, kCatoms);
}

TEST(Links, TellWhoeverReadsApartWhatHasChanged) {
    Links links(true);
    links.room(0, 1);
    links.room(1, 2);
    // Links of the start are read in place, and nobody is told of them.
    links.connect(0, 0, 1, 0);
    EXPECT_TRUE(links.read(0, 0) == 1 && links.read(1, 0) == 0);
    EXPECT_TRUE(links.take_changes().empty());
    links.disconnect(0, 0);
    EXPECT_EQ(links.take_changes().size(), 2u);
    links.connect(0, 0, 1, 1);
    const std::vector<Links::Change> made = links.take_changes();
    ASSERT_EQ(made.size(), 2u);
    EXPECT_TRUE(made[0].made && made[0].reader == 0 && made[0].other == 1 && made[1].reader == 1 && made[1].port == 1);
    EXPECT_EQ(links.read(0, 0), -1);
    links.read_at(0, 0, 5);
    Geometry g;
    links.add_to(g);
    EXPECT_EQ(g.link_read[g.link_first[0]], 5);
    EXPECT_EQ(neighbour_at(g, 0, 0), 1);
    links.disconnect(1, 1);
    const std::vector<Links::Change> gone = links.take_changes();
    ASSERT_EQ(gone.size(), 2u);
    EXPECT_TRUE(!gone[1].made && gone[1].reader == 0 && gone[1].read == 5);
    EXPECT_TRUE(links.take_changes().empty());
}

TEST(Links, SayPortsThatNeedMoreThanSixteenBits) {
    constexpr Port kMany = 70'000;
    Links links(false);
    links.reserve(2, 3);
    for (Catom c = 0; c < 3; ++c) links.room(c, 2);
    links.connect(0, 1, 1, 0);
    links.connect(2, 1, 1, 1);
    Geometry g;
    links.add_to(g);
    EXPECT_EQ(port_there(g, 1, 0), 1);
    links.room(0, kMany);
    links.connect(0, kMany - 1, 2, 0);
    links.add_to(g);
    EXPECT_EQ(links.port_there(2, 0), kMany - 1);
    EXPECT_EQ(port_there(g, 2, 0), i32{kMany - 1});
    // What was there before is there as it was.
    EXPECT_EQ(port_there(g, 1, 0), 1);
    EXPECT_EQ(port_there(g, 0, 1), 0);
    EXPECT_EQ(port_there(g, 2, 1), 1);
    links.disconnect(2, 0);
    EXPECT_EQ(links.at(0, kMany - 1), std::nullopt);
}

TEST(Links, KeepUntilWhenSomethingIsUnderWay) {
    Links links(true);
    links.keep_last_arrivals();
    links.room(0, 1);
    links.room(1, 1);
    links.connect(0, 0, 1, 0);
    EXPECT_EQ(links.last_arrival(0, 0, 10), 10);
    links.set_last_arrival(0, 0, 14);
    EXPECT_EQ(links.last_arrival(0, 0, 10), 14);
    EXPECT_EQ(links.last_arrival(1, 0, 10), 10);
    EXPECT_EQ(links.last_arrival(0, 0, 15), 15);
    // Rows take it along, also where ticks need more than 32 bits.
    constexpr std::int64_t kLate = (std::int64_t{5} << 32) - 2;
    links.set_last_arrival(0, 0, kLate + 7);
    links.room(0, 3);
    EXPECT_EQ(links.last_arrival(0, 0, kLate), kLate + 7);
    // What arrived long ago does not come back, and what is to come stays.
    constexpr std::int64_t kMostUnderWay = 10'000;
    std::int64_t later = kLate;
    for (int i = 0; i < 9; ++i) {
        later += Links::kForgetTicks;
        if (i == 4) links.set_last_arrival(1, 0, later + kMostUnderWay);
        links.forget_arrivals(later);
        EXPECT_EQ(links.last_arrival(0, 0, later + i * 1'000), later + i * 1'000);
        EXPECT_EQ(links.last_arrival(1, 0, later), later + (i == 4 ? kMostUnderWay : 0));
    }
    // A link that is made anew knows nothing of the one before.
    links.set_last_arrival(0, 0, later + 9);
    links.renew(0);
    EXPECT_EQ(links.last_arrival(0, 0, later), later);
}

TEST(Links, AreQuietWhereARunBeginsLate) {
    // Ticks that seem to come after 0 if 32 bits of them are seen.
    for (const std::int64_t now : {std::int64_t{3} << 30, (std::int64_t{7} << 32) + (std::int64_t{3} << 30)}) {
        Links links(true);
        links.keep_last_arrivals();
        links.room(0, 1);
        links.room(1, 1);
        links.connect(0, 0, 1, 0);
        links.begin_arrivals(now);
        EXPECT_EQ(links.last_arrival(0, 0, now), now);
        links.room(1, 2);
        links.renew(1);
        EXPECT_EQ(links.last_arrival(1, 0, now + 5), now + 5);
    }
}

}  // namespace
}  // namespace meld::world
