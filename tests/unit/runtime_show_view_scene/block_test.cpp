#include "runtime/show/view/scene/block.h"

#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

namespace meld::view {
namespace {

// Reads a block from its beginning on.
class Reader {
  public:
    explicit Reader(const std::string& bytes) : bytes_(bytes) {}
    template <class T>
    T next() {
        T value{};
        EXPECT_LE(at_ + sizeof value, bytes_.size());
        if (at_ + sizeof value > bytes_.size()) return value;
        std::memcpy(&value, bytes_.data() + at_, sizeof value);
        at_ += sizeof value;
        return value;
    }
    template <class T>
    std::vector<T> next(std::size_t count) {
        std::vector<T> out;
        for (std::size_t i = 0; i < count; ++i) out.push_back(next<T>());
        return out;
    }
    std::string text(std::size_t size) {
        std::string out = bytes_.substr(at_, size);
        at_ += size;
        return out;
    }
    bool done() const { return at_ == bytes_.size(); }

  private:
    const std::string& bytes_;
    std::size_t at_ = 0;
};

using Numbers = std::vector<std::uint32_t>;
using Floats = std::vector<float>;
using Bytes = std::vector<std::uint8_t>;

picture::Frame two_catoms() {
    picture::Frame frame{.tick = (std::int64_t{3} << 32) + 7, .catoms = 9, .ids = {4, 5}};
    frame.scene = {
        .form = render::Form::Cube, .places = {{0, 1, 2}, {-3, 4, 0.5F}}, .diameters = {1, 0.5F}, .colours = {{1, 2, 3}, {4, 5, 6}}};
    return frame;
}

TEST(FrameBlock, HoldsCatomsInTheOrderOfItsDescription) {
    const std::string block = frame_block(two_catoms());
    Reader in(block);
    EXPECT_EQ(in.next<std::uint32_t>(16), (Numbers{kBlockMagic, kBlockVersion, 7, 3, 2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0}));
    EXPECT_EQ(in.next<float>(6), (Floats{0, 1, 2, -3, 4, 0.5F}));
    EXPECT_EQ(in.next<float>(2), (Floats{1, 0.5F}));
    EXPECT_EQ(in.next<std::uint32_t>(2), (Numbers{4, 5}));
    EXPECT_EQ(in.next<std::uint8_t>(8), (Bytes{1, 2, 3, 255, 4, 5, 6, 255}));
    EXPECT_TRUE(in.done());
}

TEST(FrameBlock, EndsWithTheShapesOfBodies) {
    picture::Frame frame = two_catoms();
    frame.scene.rounded = {{{1, 2, 3}, 0.25F, {0.5F, 0.5F, -0.5F, 0.5F}}, {{0, 0, 4}, 0.5F, {1, 0, 0, 0}}};
    const std::string block = frame_block(frame), as_balls = frame_block(two_catoms());
    ASSERT_EQ(block.size(), as_balls.size() + 2 * 32);
    const std::string bodies = block.substr(as_balls.size());
    Reader in(bodies);
    EXPECT_EQ(Reader(block).next<std::uint32_t>(16)[5], kBodies);
    EXPECT_EQ(in.next<float>(16), (Floats{1, 2, 3, 0.25F, 0.5F, -0.5F, 0.5F, 0.5F, 0, 0, 4, 0.5F, 0, 0, 0, 1}));
    EXPECT_TRUE(in.done());
}

TEST(FrameBlock, HasHighWordsOfLargeIdsAndDiametersOfAllCatoms) {
    picture::Frame frame = two_catoms();
    frame.ids[1] = (std::uint64_t{2} << 32) + 5;
    frame.scene.diameters.clear();
    const std::string block = frame_block(frame);
    Reader in(block);
    EXPECT_EQ(in.next<std::uint32_t>(16)[5], kWideIds);
    in.next<float>(6);
    EXPECT_EQ(in.next<float>(2), (Floats{1, 1}));
    EXPECT_EQ(in.next<std::uint32_t>(4), (Numbers{4, 5, 0, 2}));
}

TEST(FrameBlock, HasLinesBeforeArrowsAndLabelsWithTheirCatoms) {
    picture::Frame frame = two_catoms();
    frame.scene.strokes = {{.from = {1, 1, 1}, .to = {2, 2, 2}, .colour = {9, 9, 9}, .arrow = true},
                           {.from = {3, 3, 3}, .to = {4, 4, 4}, .colour = {8, 8, 8}}};
    frame.scene.notes = {{{-3, 4, 0.5F}, "five"}, {{0, 1, 2}, "\xc3\xa9 four"}};
    const std::string block = frame_block(frame);
    Reader in(block);
    const Numbers header = in.next<std::uint32_t>(16);
    EXPECT_EQ((Numbers{header[6], header[7], header[8]}), (Numbers{1, 1, 2}));
    in.next<std::uint32_t>(2 * 6);
    EXPECT_EQ(in.next<float>(6), (Floats{3, 3, 3, 4, 4, 4}));
    EXPECT_EQ(in.next<std::uint8_t>(4), (Bytes{8, 8, 8, 255}));
    EXPECT_EQ(in.next<float>(6), (Floats{1, 1, 1, 2, 2, 2}));
    EXPECT_EQ(in.next<std::uint8_t>(4), (Bytes{9, 9, 9, 255}));
    EXPECT_EQ(in.next<std::uint32_t>(2), (Numbers{1, 4}));
    EXPECT_EQ(in.text(4), "five");
    EXPECT_EQ(in.next<std::uint32_t>(2), (Numbers{0, 7}));
    EXPECT_EQ(in.text(8), std::string("\xc3\xa9 four\0", 8));
    EXPECT_TRUE(in.done());
}

TEST(FrameWords, HasLampsWhereThereAreAny) {
    picture::Frame frame;
    frame.scene.lamps = {{render::Vec(1, -2, 3)}, {render::Vec(0, 0, 0.5F), 0.25F}};
    EXPECT_EQ(frame_words(frame, {})["lamps"][1].dump(), "[0.0,0.0,0.5,0.25]");
    EXPECT_EQ(frame_words(frame, {})["lamps"].size(), 2U);
}

TEST(FrameWords, HasTheBoundsAndWhatColoursMean) {
    const render::Legend kinds{.title = "name", .kinds = {{"first", {255, 0, 16}}}};
    EXPECT_EQ(frame_words(two_catoms(), kinds).dump(),
              R"({"tick":12884901895,"catoms":9,"shown":2,"legend":{"title":"name","kinds":[["first","#ff0010"]]},)"
              R"("bounds":[-3.0,1.0,0.5,0.0,4.0,2.0]})");
    const render::Legend scale{.title = "d", .scale = render::Legend::Scale{.low = 0, .high = 9, .map = *render::ColourMap::named("grey")}};
    EXPECT_EQ(legend_json(scale).dump(), R"({"title":"d","scale":{"low":0.0,"high":9.0,"whole":true,"stops":["#303030","#f0f0f0"]}})");
    EXPECT_EQ(frame_words({}, {}).dump(), R"({"tick":0,"catoms":0,"shown":0,"legend":null,"bounds":null})");
}

}  // namespace
}  // namespace meld::view
