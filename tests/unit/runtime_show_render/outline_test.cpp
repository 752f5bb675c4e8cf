#include "runtime/show/render/outline.h"

#include <gtest/gtest.h>

#include <cmath>

namespace meld::render {
namespace {

constexpr std::size_t kWidth = 320, kHeight = 240;

// A crooked heap, different for each number.
Scene heap(int number) {
    Scene out;
    for (int i = 0; i < 400; ++i) {
        const float t = static_cast<float>(i + 400 * number);
        out.places.emplace_back(9 * std::sin(1.7F * t), 4 * std::sin(2.3F * t + 1) + static_cast<float>(3 * number),
                                6 * std::sin(0.9F * t));
    }
    return out;
}

TEST(Outline, LeavesTheSameRoomAsAllScenes) {
    for (const float angle : {0.0F, 25.0F, 60.0F})
        for (const float azimuth : {-60.0F, 10.0F, 130.0F}) {
            const View view{.azimuth_deg = azimuth, .angle_deg = angle};
            Camera whole(view, kWidth, kHeight, {}), less(view, kWidth, kHeight, {});
            Outline outline(view, static_cast<float>(kWidth) / kHeight);
            for (int i = 0; i < 3; ++i) {
                whole.include(heap(i));
                outline.include(heap(i));
            }
            less.include(outline.scene());
            whole.fit();
            less.fit();
            EXPECT_LT(outline.scene().places.size(), 100U);
            for (const Vec& at : {Vec(0, 0, 0), Vec(9, 4, 6), Vec(-9, 10, -6)}) {
                EXPECT_NEAR(whole.project(at).x, less.project(at).x, 0.005F * kWidth) << angle << " " << azimuth;
                EXPECT_NEAR(whole.project(at).y, less.project(at).y, 0.005F * kHeight) << angle << " " << azimuth;
            }
        }
}

TEST(Outline, FromAllSidesIsABallAroundEverything) {
    Outline outline = Outline::from_all_sides();
    Scene scene = heap(0);
    scene.strokes = {{.from = Vec(0, 0, 0), .to = Vec(0, 0, 20), .radius = 0.5F}};
    outline.include(scene);
    const Scene ball = outline.scene();
    ASSERT_EQ(ball.places.size(), 1U);
    for (std::size_t i = 0; i < scene.places.size(); ++i)
        EXPECT_LE((scene.places[i] - ball.places[0]).norm() + scene.reach(i), ball.reach(0) * 1.0001F) << i;
    EXPECT_LE((scene.strokes[0].to - ball.places[0]).norm() + 0.5F, ball.reach(0) * 1.0001F);
}

TEST(Outline, OfNothingIsEmpty) {
    EXPECT_TRUE(Outline({}, 1).scene().places.empty());
    EXPECT_TRUE(Outline::from_all_sides().scene().places.empty());
}

}  // namespace
}  // namespace meld::render
