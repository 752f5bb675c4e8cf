#include "runtime/show/render/cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "runtime/show/render/paint.h"

namespace meld::render {
namespace {

// A cube of so many catoms along each side; rows begin with x.
Scene cube(int side) {
    Scene out{.ways = {kAxes.begin(), kAxes.end()}};
    for (int z = 0; z < side; ++z)
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                out.places.emplace_back(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
                out.colours.push_back(
                    {static_cast<std::uint8_t>(6 * x), static_cast<std::uint8_t>(6 * y), static_cast<std::uint8_t>(6 * z)});
            }
    return out;
}

Painted see(const Scene& scene) {
    constexpr std::size_t kWidth = 160, kHeight = 120;
    Camera camera({}, kWidth, kHeight, {});
    camera.include(scene);
    camera.fit();
    Workers workers(2);
    const Result<Geometry> geometry = Geometry::build(scene, 2);
    EXPECT_TRUE(geometry);
    return paint(scene, *geometry, camera, kWidth, kHeight, Rgb{255, 255, 255}, {}, workers);
}

TEST(Cells, KnowHowDeepCatomsAre) {
    const Scene scene = cube(7);
    const std::optional<Cells> cells = Cells::of(scene, scene.ways);
    ASSERT_TRUE(cells);
    const std::vector<std::uint8_t> depths = cells->depths(2);
    for (std::size_t i = 0; i < scene.places.size(); ++i) {
        const Vec from_middle = scene.places[i] - Vec(3, 3, 3);
        const int depth = 3 - static_cast<int>(from_middle.cwiseAbs().maxCoeff());
        EXPECT_EQ(depths[i], std::min(depth, 2)) << i;
        for (std::size_t way = 0; way < kAxes.size(); ++way)
            EXPECT_EQ(cells->has_next(i, way), (from_middle + kAxes[way]).cwiseAbs().maxCoeff() < 3.5F) << i << " " << way;
    }
}

TEST(Cells, AreOfLatticesOnly) {
    Scene scene = cube(3);
    scene.places[4].x() += 0.2F;
    EXPECT_FALSE(Cells::of(scene, scene.ways));
    EXPECT_FALSE(Cells::of(cube(3), {}));
    EXPECT_FALSE(Cells::of(Scene{}, kAxes));
}

// Without ways nothing is known to be behind others, and all is drawn.
TEST(Cells, LeaveOutOfPicturesOnlyWhatIsNotSeen) {
    Scene scene = cube(38);  // More than 50,000, from which on catoms are left out.
    const Painted culled = see(scene);
    scene.ways.clear();
    const Painted whole = see(scene);
    ASSERT_EQ(culled.image.pixels.size(), whole.image.pixels.size());
    // Of the few rays that get through three layers of balls some meet another ball.
    std::size_t others = 0;
    for (std::size_t i = 0; i < whole.image.pixels.size(); ++i) {
        int most = 0;
        for (const int shift : {0, 8, 16})
            most = std::max(most, std::abs(static_cast<int>(culled.image.pixels[i] >> shift & 255) -
                                           static_cast<int>(whole.image.pixels[i] >> shift & 255)));
        others += most > 8 ? 1 : 0;
    }
    EXPECT_LE(others, whole.image.pixels.size() / 500);
}

}  // namespace
}  // namespace meld::render
