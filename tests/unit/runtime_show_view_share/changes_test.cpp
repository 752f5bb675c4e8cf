// What a page that needs no server knows of catoms without a value, and of those that are no spheres.
#include "runtime/show/view/share/changes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

namespace meld::view {
namespace {

constexpr std::size_t kHeader = 48;

// Of one catom, coloured by D.
picture::Frame frame(std::int64_t tick) {
    picture::Frame frame{.tick = tick, .catoms = 1, .ids = {7}, .coloured_by = "D"};
    frame.scene.places = {render::Vec(0, 0, 0)};
    frame.scene.colours = {render::Rgb{176, 176, 176}};
    return frame;
}

// What stands for its colour: after the header, its number, its place and its diameter.
std::uint32_t colour(const std::string& record) {
    std::uint32_t out = 0;
    std::memcpy(&out, record.data() + kHeader + 8 + 12 + 4, sizeof out);
    return out;
}

float as_float(std::uint32_t bits) {
    float out = 0;
    std::memcpy(&out, &bits, sizeof out);
    return out;
}

TEST(Changes, NoValueIsNotZeroBeforeTheFirstNumber) {
    Changes changes;
    EXPECT_TRUE(std::isnan(as_float(colour(changes.record(frame(0), {}, true)))));
    picture::Frame next = frame(1);
    next.numbers = {{0, 0.0}};
    EXPECT_EQ(as_float(colour(changes.record(next, {}, false))), 0.0F);
    EXPECT_TRUE(std::isnan(as_float(colour(changes.record(frame(2), {}, false)))));
}

TEST(Changes, NoValueIsNoWordBeforeTheFirstWord) {
    Changes changes;
    EXPECT_GT(colour(changes.record(frame(0), {}, true)), 1000000U);
    picture::Frame next = frame(1);
    next.words = {{0, "first"}};
    EXPECT_EQ(colour(changes.record(next, {}, false)), 1U);
    EXPECT_EQ(colour(changes.record(frame(2), {}, false)), 0U);
}

// The numbers that follow what is known of catoms without shapes, if there is one catom or none.
std::vector<float> body(const std::string& record, std::size_t catoms) {
    std::vector<float> out((record.size() - kHeader - 28 * catoms) / sizeof(float));
    std::memcpy(out.data(), record.data() + kHeader + 28 * catoms, out.size() * sizeof(float));
    return out;
}

std::uint32_t kind(const std::string& record) {
    std::uint32_t out = 0;
    std::memcpy(&out, record.data(), sizeof out);
    return out;
}

TEST(Changes, ShapesComeWithTheCatomsThatAreSet) {
    picture::Frame next = frame(0);
    next.scene.rounded = {{{1, 2, 3}, 0.25F, {0.5F, 0.5F, -0.5F, 0.5F}}};
    Changes changes;
    const std::string first = changes.record(next, {}, true);
    EXPECT_EQ(kind(first), 2U);
    EXPECT_EQ(body(first, 1), (std::vector<float>{1, 2, 3, 0.25F, 0.5F, -0.5F, 0.5F, 0.5F}));
    // Nothing has changed.
    EXPECT_EQ(changes.record(next, {}, false).size(), kHeader);
    // It turns where it stands.
    next.scene.rounded[0].turn = {1, 0, 0, 0};
    const std::string turned = changes.record(next, {}, false);
    EXPECT_EQ(kind(turned), 3U);
    EXPECT_EQ(body(turned, 1), (std::vector<float>{1, 2, 3, 0.25F, 0, 0, 0, 1}));
}

TEST(Changes, ShapesOfAllCatomsComeInTheirOrder) {
    picture::Frame two = frame(0);
    two.ids = {7, 9};
    two.scene.places.emplace_back(1, 0, 0);
    two.scene.colours.emplace_back();
    two.scene.rounded = {{{1, 1, 1}, 0.25F, {1, 0, 0, 0}}, {{0, 0, 2}, 0.5F, {0, 1, 0, 0}}};
    Changes changes;
    EXPECT_EQ(body(changes.record(two, {}, true), 2), (std::vector<float>{1, 1, 1, 0.25F, 0, 0, 2, 0.5F, 0, 0, 0, 1, 1, 0, 0, 0}));
    two.scene.rounded[1].core = {0, 0, 3};
    EXPECT_EQ(body(changes.record(two, {}, false), 1), (std::vector<float>{0, 0, 3, 0.5F, 1, 0, 0, 0}));
}

TEST(Changes, RecordsOfSpheresAreAsBefore) {
    Changes changes;
    const std::string first = changes.record(frame(0), {}, true);
    EXPECT_EQ(kind(first), 0U);
    EXPECT_EQ(first.size(), kHeader + 28);
    EXPECT_EQ(kind(changes.record(frame(1), {}, false)), 1U);
}

}  // namespace
}  // namespace meld::view
