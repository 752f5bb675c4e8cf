#include "runtime/show/render/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace meld::render {
namespace {

Scene box(int x, int y, int z) {
    Scene out;
    for (int i = 0; i < x; ++i)
        for (int j = 0; j < y; ++j)
            for (int k = 0; k < z; ++k) out.places.emplace_back(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k));
    out.colours.resize(out.places.size());
    return out;
}

// Whatever is seen from wherever, all of it is between the margins, and touches two of them.
TEST(Camera, FitsWhatIsSeen) {
    const Margins margins{.left = 0.05F, .right = 0.2F, .top = 0.1F, .bottom = 0.15F};
    for (const float angle : {0.0F, 25.0F, 70.0F})
        for (const float azimuth : {-60.0F, 0.0F, 133.0F})
            for (const float elevation : {-90.0F, -20.0F, 25.0F, 90.0F})
                for (const Scene& scene : {box(1, 1, 1), box(9, 2, 1), box(3, 3, 12)}) {
                    Camera camera({.azimuth_deg = azimuth, .elevation_deg = elevation, .angle_deg = angle}, 400, 300, margins);
                    camera.include(scene);
                    camera.fit();
                    float left = 1e9F, right = -1e9F, top = 1e9F, bottom = -1e9F;
                    // The outline of a ball, by rays that pass it at its distance.
                    for (const Vec& place : scene.places)
                        for (int i = 0; i < 3; ++i)
                            for (const float side : {-0.5F, 0.5F}) {
                                const Camera::Pixel at = camera.project(place + side * Vec::Unit(i));
                                left = std::min(left, at.x);
                                right = std::max(right, at.x);
                                top = std::min(top, at.y);
                                bottom = std::max(bottom, at.y);
                            }
                    const float lacking = std::min({left - 20, 320 - right, top - 30, 255 - bottom});
                    EXPECT_GE(lacking, -0.01F) << angle << " " << azimuth << " " << elevation;
                    const float spare = std::min(std::max(left - 20, 320 - right), std::max(top - 30, 255 - bottom));
                    // Balls reach further than the six places of each that were looked at, and most where there is only one.
                    EXPECT_LE(spare, scene.places.size() == 1 ? 60 : 30) << angle << " " << azimuth << " " << elevation;
                }
}

TEST(Camera, RaysMeetWhatIsProjectedToTheirPixel) {
    for (const float angle : {0.0F, 40.0F}) {
        Camera camera({.angle_deg = angle}, 300, 200, {});
        camera.include(box(4, 5, 6));
        camera.fit();
        for (const Vec& place : box(4, 5, 6).places) {
            const Camera::Pixel at = camera.project(place);
            const Camera::Ray ray = camera.ray(at.x, at.y);
            EXPECT_LT((ray.from + at.distance * ray.along - place).norm(), 1e-3F);
        }
    }
}

// x to the right and y upwards from above; z upwards from the side: nothing is mirrored.
TEST(Camera, ShowsAxesAsTheyAre) {
    const auto seen = [](const View& view, const Vec& at) {
        Camera camera(view, 100, 100, {});
        camera.include(box(3, 3, 3));
        camera.fit();
        return camera.project(at);
    };
    const View above{.azimuth_deg = -90, .elevation_deg = 90, .angle_deg = 0},
        front{.azimuth_deg = -90, .elevation_deg = 0, .angle_deg = 0};
    EXPECT_GT(seen(above, {2, 1, 1}).x, seen(above, {0, 1, 1}).x);
    EXPECT_LT(seen(above, {1, 2, 1}).y, seen(above, {1, 0, 1}).y);
    EXPECT_LT(seen(above, {1, 1, 2}).distance, seen(above, {1, 1, 0}).distance);
    EXPECT_GT(seen(front, {2, 1, 1}).x, seen(front, {0, 1, 1}).x);
    EXPECT_LT(seen(front, {1, 1, 2}).y, seen(front, {1, 1, 0}).y);
    EXPECT_GT(seen(front, {1, 2, 1}).distance, seen(front, {1, 0, 1}).distance);
}

}  // namespace
}  // namespace meld::render
