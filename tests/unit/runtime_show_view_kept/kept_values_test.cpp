#include "runtime/show/view/kept/kept_values.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <map>
#include <random>

#include "runtime/show/picture/palette.h"

namespace meld::view {
namespace {

using Kind = KeptValues::Kind;

constexpr std::uint64_t kCatoms = 10000;

std::uint64_t bits_of(Kind kind, int number) {
    return kind == Kind::Whole ? static_cast<std::uint64_t>(std::int64_t{number}) : std::bit_cast<std::uint64_t>(number / 4.0);
}

// What a legend says of the values of all catoms, and of those that stand for them.
void expect_same_legend(KeptValues& values) {
    const picture::Look look{.colour = "some(A, N)"};
    picture::Frame all = values.witness();
    const picture::Frame few = all;
    all.numbers.clear();
    all.words.clear();
    for (std::uint64_t catom = 0; catom < kCatoms; ++catom) values.put(catom, catom, all);
    picture::Palette of_all(look), of_few(look);
    of_all.include(all);
    of_few.include(few);
    const auto expected = of_all.settle(), legend = of_few.settle();
    ASSERT_EQ(legend.has_value(), expected.has_value());
    if (!expected) return;
    EXPECT_EQ(legend->kinds, expected->kinds);
    ASSERT_EQ(legend->scale.has_value(), expected->scale.has_value());
    if (!expected->scale) return;
    EXPECT_EQ(legend->scale->low, expected->scale->low);
    EXPECT_EQ(legend->scale->high, expected->scale->high);
}

TEST(KeptValues, MeanTheSameToAPaletteAsTheyAllDo) {
    std::mt19937 random(7);
    for (const Kind kind : {Kind::Whole, Kind::Real})
        for (const int most : {1, 3, 7, 8, 9, 10, 5000}) {
            KeptValues values(kind);
            values.resize(kCatoms);
            expect_same_legend(values);
            for (int round = 0; round < 5; ++round) {
                for (int i = 0; i < 300; ++i) {
                    const int number = static_cast<int>(random() % static_cast<unsigned>(most)) - most / 2;
                    values.set(random() % kCatoms, random() % 3 == 0 ? std::nullopt : std::optional(bits_of(kind, number)));
                }
                expect_same_legend(values);
            }
        }
}

TEST(KeptValues, SaysWhetherAValueIsAnotherOne) {
    KeptValues values(Kind::Whole);
    values.resize(kCatoms);
    EXPECT_FALSE(values.set(4, std::nullopt));
    EXPECT_TRUE(values.set(4, 0));
    EXPECT_FALSE(values.set(4, 0));
    EXPECT_TRUE(values.set(4, 5));
    EXPECT_TRUE(values.set(4, std::nullopt));
    EXPECT_TRUE(values.witness().numbers.empty());
}

TEST(KeptValues, ForgetsWordsThatNobodyHas) {
    KeptValues values(Kind::Text);
    values.resize(kCatoms);
    std::map<std::uint64_t, std::string> expected;
    for (int round = 0; round < 1000; ++round) {
        const std::uint64_t catom = static_cast<std::uint64_t>(round) % 3;
        const std::string word = "word " + std::to_string(round / 2);
        values.set(catom, values.word(word));
        expected[catom] = word;
    }
    std::vector<std::string> words;
    for (const auto& [place, word] : values.witness().words) words.push_back(word);
    std::ranges::sort(words);
    std::vector<std::string> left;
    for (const auto& [catom, word] : expected) left.push_back(word);
    std::ranges::sort(left);
    left.erase(std::ranges::unique(left).begin(), left.end());
    EXPECT_EQ(words, left);
    for (const auto& [catom, word] : expected) {
        picture::Frame frame;
        values.put(catom, 0, frame);
        EXPECT_EQ(frame.words.front().second, word);
    }
}

}  // namespace
}  // namespace meld::view
