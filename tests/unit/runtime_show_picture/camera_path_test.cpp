#include "runtime/show/picture/camera_path.h"

#include <gtest/gtest.h>

namespace meld::picture {
namespace {

const render::View kView{.azimuth_deg = 10, .elevation_deg = 20, .zoom = 1, .angle_deg = 30};

TEST(CameraPath, StaysWithoutTurnOrKeys) {
    const CameraPath path(kView, 0);
    EXPECT_FALSE(path.moves());
    EXPECT_EQ(path.at(7, 3, 9).azimuth_deg, 10);
}

TEST(CameraPath, TurnsEvenlyAndDoesNotEndWhereItBegan) {
    const CameraPath path(kView, 360);
    EXPECT_TRUE(path.moves());
    EXPECT_FLOAT_EQ(path.at(0, 0, 8).azimuth_deg, 10);
    EXPECT_FLOAT_EQ(path.at(70, 2, 8).azimuth_deg, 100);
    EXPECT_FLOAT_EQ(path.at(99, 7, 8).azimuth_deg, 325);
}

TEST(CameraPath, GoesThroughItsKeysAndNeverBeyond) {
    const CameraPath path(kView, {{10, 0, 0, 1}, {20, 90, 30, 4}, {40, 100, 10, 4}});
    EXPECT_TRUE(path.moves());
    const auto azimuth = [&](std::int64_t tick) { return path.at(tick, 0, 1).azimuth_deg; };
    for (const auto& [tick, at] :
         {std::pair(0, 0.0F), std::pair(10, 0.0F), std::pair(20, 90.0F), std::pair(40, 100.0F), std::pair(90, 100.0F)})
        EXPECT_NEAR(azimuth(tick), at, 1e-4F) << tick;
    for (std::int64_t tick = 10; tick < 40; ++tick) {
        EXPECT_LE(azimuth(tick), azimuth(tick + 1) + 1e-4F) << tick;
        EXPECT_LE(path.at(tick, 0, 1).elevation_deg, 30.0F + 1e-4F) << tick;
        EXPECT_LE(path.at(tick, 0, 1).zoom, 4.0F + 1e-4F) << tick;
    }
    // It begins slowly, and the zoom grows by factors: halfway it is the mean of them.
    EXPECT_LT(azimuth(11) - azimuth(10), azimuth(15) - azimuth(14));
    EXPECT_NEAR(CameraPath(kView, {{0, 0, 0, 1}, {10, 0, 0, 4}}).at(5, 0, 1).zoom, 2.0F, 1e-4F);
    EXPECT_EQ(path.at(15, 0, 1).angle_deg, 30);
}

TEST(CameraPath, StaysAtASingleKey) {
    const CameraPath path(kView, {{5, 40, 50, 2}});
    EXPECT_FALSE(path.moves());
    EXPECT_FLOAT_EQ(path.at(0, 0, 2).azimuth_deg, 40);
    EXPECT_FLOAT_EQ(path.at(9, 1, 2).zoom, 2);
}

}  // namespace
}  // namespace meld::picture
