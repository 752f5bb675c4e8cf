// What a page that needs no server knows of catoms without a value.
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

}  // namespace
}  // namespace meld::view
