#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "runtime/driver/shrink/ddmin.h"
#include "runtime/driver/shrink/failure.h"
#include "runtime/driver/shrink/sizes.h"

namespace meld::driver {
namespace {

// What is left of so many items of which these are needed together, and how many tries that took.
struct Found {
    Kept kept;
    std::size_t tries = 0;
};
Found minimize(std::size_t items, const std::function<bool(const Kept&)>& fails) {
    Found found;
    found.kept = *ddmin(items, [&](std::size_t count, const std::function<Kept(std::size_t)>& candidate) {
        for (std::size_t i = 0; i < count; ++i) {
            ++found.tries;
            if (fails(candidate(i))) return Result<std::optional<std::size_t>>(i);
        }
        return Result<std::optional<std::size_t>>(std::nullopt);
    });
    return found;
}

bool has_all(const Kept& kept, const std::set<std::size_t>& needed) {
    return std::ranges::all_of(needed, [&](std::size_t one) { return std::ranges::binary_search(kept, one); });
}

TEST(Ddmin, FindsWhatIsNeededTogether) {
    for (const std::set<std::size_t>& needed :
         {std::set<std::size_t>{}, {0}, {99}, {50}, {3, 4}, {0, 99}, {10, 30, 50, 70, 90}, {7, 8, 9, 10, 11, 12}}) {
        const Found found = minimize(100, [&](const Kept& kept) { return has_all(kept, needed); });
        EXPECT_EQ(std::set<std::size_t>(found.kept.begin(), found.kept.end()), needed);
        EXPECT_LE(found.tries, 1 + 30 * needed.size());
    }
}

TEST(Ddmin, KeepsAllOfAListOfWhichNothingCanGo) {
    EXPECT_EQ(minimize(17, [](const Kept& kept) { return kept.size() == 17; }).kept.size(), 17U);
    EXPECT_EQ(minimize(1, [](const Kept& kept) { return kept.size() == 1; }).kept, Kept{0});
    EXPECT_TRUE(minimize(0, [](const Kept&) { return false; }).kept.empty());
}

TEST(Ddmin, LeavesNothingThatCouldGoAlone) {
    // An odd number of items, the first one among them: such a fault is not monotone.
    const auto fails = [](const Kept& kept) { return !kept.empty() && kept[0] == 0 && kept.size() % 2 == 1; };
    const Found found = minimize(63, fails);
    EXPECT_TRUE(fails(found.kept));
    for (std::size_t i = 0; i < found.kept.size(); ++i) {
        Kept fewer = found.kept;
        fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(i));
        EXPECT_FALSE(fails(fewer));
    }
}

TEST(Failure, NumbersOfARunDoNotMatterAndThoseOfTheProgramDo) {
    for (const auto& [text, wanted] : {
             std::pair("catom @12 in tick 3: p@14 at (-1, 0, 25)", "catom @# in tick #: p@14 at (#, #, #)"),
             {"/tmp/a1/w.toml:3:12: no such cell", "WORLD:#:#: no such cell"},
             {"my.meld:31:12: 12 / 0", "my.meld:31:12: # / #"},
             {"more than 500 in rule far-p@23 at catom @4", "more than # in rule far-p@23 at catom @#"},
             {"0.25 and x2", "#.# and x#"},
             {"", ""},
         })
        EXPECT_EQ(without_numbers(text, "/tmp/a1/w.toml"), wanted);
}

TEST(Sizes, AreWholeNumbersThatStandForThemselves) {
    constexpr std::string_view kWorld =
        "graph = \"small_world(1k, 4, 0.2)\"\n"
        "[[body]]\nshape = \"minus(box(20, 1, 3), mesh('part2.stl', size = 60))\"\n"
        "[[body]]\ncells = [[7, 7]]\n"
        "[[body]]\nshape = \"sphere(r=4.5)\"\n";
    toml::table keys = toml::parse(kWorld);
    std::vector<std::int64_t> found;
    for (const SizePlace& place : sizes_in(keys)) {
        found.push_back(size_at(keys, place));
        set_size(keys, place, found.back() / 2);
    }
    EXPECT_EQ(found, (std::vector<std::int64_t>{1000, 4, 20, 3, 60}));
    EXPECT_EQ(keys["graph"].value_or(std::string()), "small_world(500, 2, 0.2)");
    EXPECT_EQ(keys["body"][0]["shape"].value_or(std::string()), "minus(box(10, 1, 1), mesh('part2.stl', size = 30))");
}

}  // namespace
}  // namespace meld::driver
