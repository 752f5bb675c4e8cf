#include "runtime/show/render/callouts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace meld::render {
namespace {

constexpr Columns kColumns{.left = 100, .right = 900, .top = 20, .bottom = 480, .step = 20};

double turn(const Anchor& p, const Anchor& q, const Anchor& r) { return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x); }

void expect_tidy(const std::vector<Anchor>& anchors, const std::vector<Label>& labels) {
    ASSERT_EQ(labels.size(), anchors.size());
    for (std::size_t i = 0; i < labels.size(); ++i) {
        EXPECT_GE(labels[i].y, kColumns.top - 1e-9);
        EXPECT_LE(labels[i].y, kColumns.bottom + 1e-9);
        for (std::size_t j = 0; j < i; ++j) {
            if (labels[i].right != labels[j].right) continue;
            EXPECT_GE(std::abs(labels[i].y - labels[j].y), kColumns.step - 1e-9) << "labels overlap";
            const double end = labels[i].right ? kColumns.right : kColumns.left;
            const Anchor a_end{end, labels[i].y}, b_end{end, labels[j].y};
            EXPECT_FALSE(turn(anchors[i], a_end, anchors[j]) * turn(anchors[i], a_end, b_end) < 0 &&
                         turn(anchors[j], b_end, anchors[i]) * turn(anchors[j], b_end, a_end) < 0)
                << "lines cross";
        }
    }
}

TEST(Callouts, StandAtTheHeightOfWhatTheyAreAboutOnTheNearerSide) {
    const std::vector<Anchor> anchors = {{200, 100}, {800, 300}, {450, 50}};
    const std::vector<Label> labels = place_labels(anchors, kColumns);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_DOUBLE_EQ(labels[i].y, anchors[i].y);
    EXPECT_FALSE(labels[0].right);
    EXPECT_TRUE(labels[1].right);
    EXPECT_FALSE(labels[2].right);
}

TEST(Callouts, MakeRoomForEachOther) {
    // Around the middle of what they want.
    const std::vector<Label> labels = place_labels(std::vector<Anchor>{{200, 200}, {210, 200}, {220, 200}}, kColumns);
    EXPECT_DOUBLE_EQ((labels[0].y + labels[1].y + labels[2].y) / 3, 200);
    // At the border they stay within it.
    EXPECT_DOUBLE_EQ(place_labels(std::vector<Anchor>{{200, 0}, {210, 2}}, kColumns)[1].y, 40);
    // What one column has no room for is in the other, and the nearest to it goes there.
    std::vector<Anchor> many;
    for (int i = 0; i < 30; ++i) many.push_back({150.0 + i, 250});
    const std::vector<Label> spread = place_labels(many, kColumns);
    EXPECT_EQ(std::ranges::count_if(spread, &Label::right), 6);
    EXPECT_TRUE(spread[29].right && spread[24].right && !spread[23].right);
    expect_tidy(many, spread);
    EXPECT_TRUE(place_labels({}, kColumns).empty());
}

TEST(Callouts, NeverOverlapAndTheirLinesNeverCross) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> x(110, 890), y(0, 500);
    for (int trial = 0; trial < 200; ++trial) {
        std::vector<Anchor> anchors(1 + random() % (2 * kColumns.capacity()));
        for (Anchor& anchor : anchors) anchor = {x(random), y(random)};
        expect_tidy(anchors, place_labels(anchors, kColumns));
    }
}

}  // namespace
}  // namespace meld::render
