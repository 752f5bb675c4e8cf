#include "runtime/show/render/paint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <vector>

#include "runtime/show/render/colours.h"

namespace meld::render {
namespace {

constexpr std::size_t kSide = 120;

struct Seen {
    Camera camera;
    Painted painted;

    Rgb at(const Vec& place) const {
        const Camera::Pixel pixel = camera.project(place);
        const std::uint32_t p = painted.image.pixels[static_cast<std::size_t>(pixel.y) * kSide + static_cast<std::size_t>(pixel.x)];
        return {static_cast<std::uint8_t>(p >> 16), static_cast<std::uint8_t>(p >> 8), static_cast<std::uint8_t>(p)};
    }
};

Seen see(const Scene& scene, const View& view, std::optional<Rgb> background = Rgb{255, 255, 255}, int threads = 1) {
    Camera camera(view, kSide, kSide, {});
    camera.include(scene);
    camera.fit();
    Workers workers(threads);
    const Result<Geometry> geometry = Geometry::build(scene, threads);
    EXPECT_TRUE(geometry);
    return {camera, paint(scene, *geometry, camera, kSide, kSide, background, {}, workers)};
}

Scene three_in_a_row() {
    return {.places = {Vec(0, 0, 0), Vec(2, 0, 0), Vec(4, 0, 0)}, .colours = {{220, 30, 30}, {30, 200, 30}, {40, 40, 230}}};
}

const View kAbove{.azimuth_deg = -90, .elevation_deg = 90, .angle_deg = 0};

TEST(Paint, GivesEachCatomItsColourAtItsPlace) {
    for (const Form form : {Form::Sphere, Form::Cube, Form::Disc, Form::Hexagon, Form::Rounded}) {
        Scene scene = three_in_a_row();
        scene.form = form;
        const Seen seen = see(scene, kAbove);
        const Rgb red = seen.at({0, 0, 0}), green = seen.at({2, 0, 0}), blue = seen.at({4, 0, 0});
        EXPECT_TRUE(red.r > 150 && red.g < 80 && red.b < 80) << static_cast<int>(form);
        EXPECT_TRUE(green.g > 130 && green.r < 80 && green.b < 80) << static_cast<int>(form);
        EXPECT_TRUE(blue.b > 150 && blue.r < 90 && blue.g < 90) << static_cast<int>(form);
        EXPECT_EQ(seen.at({1, 0, 0}), (Rgb{255, 255, 255})) << static_cast<int>(form);
    }
}

TEST(Paint, HidesWhatIsBehind) {
    const Scene scene{.places = {Vec(0, 0, 0), Vec(0, 0, 3)}, .colours = {{220, 30, 30}, {40, 40, 230}}};
    EXPECT_GT(see(scene, kAbove).at({0, 0, 0}).b, 150);
    EXPECT_GT(see(scene, {.azimuth_deg = -90, .elevation_deg = -90, .angle_deg = 0}).at({0, 0, 0}).r, 150);
}

TEST(Paint, DarkensWhatIsInTheShade) {
    // A wall over the middle of a floor.
    Scene scene{.form = Form::Cube};
    for (int x = -6; x <= 6; ++x)
        for (int y = -6; y <= 6; ++y) scene.places.emplace_back(static_cast<float>(x), static_cast<float>(y), 0.0F);
    for (int z = 1; z <= 4; ++z) scene.places.emplace_back(0.0F, 0.0F, static_cast<float>(z));
    scene.colours.assign(scene.places.size(), {200, 200, 200});
    const Seen seen = see(scene, kAbove);
    // The sun stands at the left, as the picture is seen; so there is shade at the right.
    EXPECT_LT(seen.at({1, 0, 0}).g + 20, seen.at({-5, -5, 0}).g);
}

TEST(Paint, ShowsLampsAsBrightInTheShadeAsOutOfIt) {
    // Beneath a roof, in the open, and behind a cube.
    Scene scene{.form = Form::Cube, .places = {Vec(0, 0, 2), Vec(4, 0, 0)}, .diameters = {3, 1}, .colours = {{90, 90, 90}, {90, 90, 90}}};
    scene.lamps = {{Vec(0, 0, 0), 0.4F}, {Vec(2.4F, 0, 0), 0.4F}, {Vec(4, 3, 0), 0.4F}};
    const Seen seen = see(scene, {.azimuth_deg = -90, .elevation_deg = 0, .angle_deg = 0});
    EXPECT_EQ(seen.at({0, 0, 0}), kLamp);
    EXPECT_EQ(seen.at({2.4F, 0, 0}), kLamp);
    EXPECT_NE(seen.at({4, 0, 0}), kLamp);
    EXPECT_EQ(seen.at({0.7F, 0, 0}), (Rgb{255, 255, 255}));
}

TEST(Paint, IsTransparentWhereThereIsNothing) {
    const Seen seen = see(three_in_a_row(), kAbove, std::nullopt);
    EXPECT_EQ(seen.painted.image.pixels.front(), 0U);
    const Camera::Pixel middle = seen.camera.project({2, 0, 0});
    EXPECT_EQ(seen.painted.image.pixels[static_cast<std::size_t>(middle.y) * kSide + static_cast<std::size_t>(middle.x)] >> 24, 255U);
    EXPECT_TRUE(std::isinf(seen.painted.distances.front()));
}

TEST(Paint, IsTheSameOnAnyNumberOfThreads) {
    Scene scene;
    for (int i = 0; i < 500; ++i)
        scene.places.emplace_back(static_cast<float>(i % 10), static_cast<float>(i / 10 % 10), static_cast<float>(i / 100));
    scene.colours.assign(scene.places.size(), {100, 150, 200});
    scene.ground = -0.5F;
    const Painted one = see(scene, {}, Rgb{255, 255, 255}, 1).painted, three = see(scene, {}, Rgb{255, 255, 255}, 3).painted;
    EXPECT_EQ(one.image.pixels, three.image.pixels);
}

TEST(Paint, DrawsStrokesAndArrows) {
    Scene scene = three_in_a_row();
    scene.strokes = {{.from = {0, 3, 0}, .to = {4, 3, 0}, .colour = {0, 0, 0}, .radius = 0.2F, .arrow = true}};
    const Seen seen = see(scene, kAbove);
    EXPECT_LT(seen.at({1, 3, 0}).r, 60);
    // The head is wider than the shaft, and begins towards the end.
    EXPECT_LT(seen.at({2.9F, 3.35F, 0}).r, 60);
    EXPECT_EQ(seen.at({1, 3.35F, 0}), (Rgb{255, 255, 255}));
}

TEST(Colours, GoFromEndToEnd) {
    for (const std::string_view name : ColourMap::names()) {
        const ColourMap map = *ColourMap::named(name);
        EXPECT_EQ(map.at(-1), map.at(0)) << name;
        EXPECT_EQ(map.at(2), map.at(1)) << name;
        EXPECT_NE(map.at(0), map.at(1)) << name;
        // No steps that look like an edge.
        for (int i = 0; i < 100; ++i) {
            const Rgb a = map.at(i / 100.0), b = map.at((i + 1) / 100.0);
            EXPECT_LE(std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b), 20) << name << " " << i;
        }
        // Those without a middle become brighter all the way.
        if (name == "coolwarm") continue;
        for (int i = 0; i < 100; ++i) EXPECT_LT(brightness(map.at(i / 100.0)), brightness(map.at((i + 1) / 100.0)) + 0.003) << name;
    }
    EXPECT_FALSE(ColourMap::named("jet"));
    EXPECT_NE(kind_colour(0), kind_colour(8));
}

TEST(Colours, AreRead) {
    EXPECT_EQ(parse_colour("#ff8000"), (Rgb{255, 128, 0}));
    EXPECT_EQ(parse_colour("#f80"), (Rgb{255, 136, 0}));
    EXPECT_EQ(parse_colour("black"), (Rgb{0, 0, 0}));
    for (const char* wrong : {"", "#", "#12345", "ff8000", "#ggg", "#ff80001", "red"}) EXPECT_FALSE(parse_colour(wrong)) << wrong;
}

}  // namespace
}  // namespace meld::render
