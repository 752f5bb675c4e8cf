// Bytes are read as they were written, and never beyond their end.
#include "runtime/base/bytes.h"

#include <gtest/gtest.h>

#include <array>

namespace meld {
namespace {

struct Point {
    std::int32_t x = 0, y = 0;
    bool operator==(const Point&) const = default;
};

TEST(Bytes, AreReadAsTheyWereWritten) {
    ByteWriter out;
    out.write(std::uint8_t{7});
    out.write(Point{3, -4});
    out.write_string("a text");
    out.write_string("");
    out.write_block(std::array{std::byte{1}, std::byte{2}});
    out.write_count(2);
    for (const double item : {0.5, 1.5}) out.write(item);
    ByteReader in(out.view(), "a test");
    EXPECT_EQ(in.read<std::uint8_t>(), 7);
    EXPECT_EQ(in.read<Point>(), (Point{3, -4}));
    EXPECT_EQ(in.read_string(), "a text");
    EXPECT_EQ(in.read_string(), "");
    EXPECT_EQ(in.read_block().size(), 2u);
    EXPECT_EQ(in.read_count(sizeof(double)), 2u);
    EXPECT_EQ(in.left(), 2 * sizeof(double));
    EXPECT_EQ(in.read<double>() + in.read<double>(), 2.0);
    EXPECT_TRUE(in.done());
    EXPECT_TRUE(in.outcome().has_value());
}

TEST(Bytes, ThatAreTakenLeaveNothing) {
    ByteWriter out;
    out.write(1);
    EXPECT_EQ(out.take().size(), sizeof(int));
    EXPECT_TRUE(out.empty());
    out.write(std::uint8_t{2});
    EXPECT_EQ(out.size(), 1u);
}

TEST(Bytes, CanBeChangedWhereTheyStand) {
    ByteWriter out;
    out.write(std::uint8_t{1});
    const std::size_t start = out.size();
    out.write(std::uint8_t{2});
    out.written_from(start)[0] = std::byte{9};
    EXPECT_EQ(out.take(), (std::vector{std::byte{1}, std::byte{9}}));
}

// Reads a whole message of several kinds of values.
void read_all(ByteReader& in) {
    in.read<std::uint64_t>();
    in.read_string();
    for (std::uint32_t left = in.read_count(sizeof(Point)); left > 0; --left) in.read<Point>();
    in.read_block();
}

TEST(Bytes, FromOutsideThatEndTooEarlyAreAnError) {
    ByteWriter out;
    out.write(std::uint64_t{1});
    out.write_string("text");
    out.write_count(2);
    out.write(Point{});
    out.write(Point{});
    out.write_block(std::array{std::byte{1}});
    const std::span<const std::byte> whole = out.view();
    ByteReader all(whole, "a snapshot", ByteReader::Origin::Outside);
    read_all(all);
    EXPECT_FALSE(all.failed());
    EXPECT_TRUE(all.done());
    for (std::size_t size = 0; size < whole.size(); ++size) {
        // A copy of its own size, so that a sanitizer sees a read beyond it.
        const std::vector<std::byte> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
        ByteReader in(cut, "a snapshot", ByteReader::Origin::Outside);
        read_all(in);
        EXPECT_TRUE(in.failed()) << size;
        EXPECT_TRUE(in.done()) << size;
        EXPECT_EQ(in.read<int>(), 0);
    }
}

TEST(Bytes, SayWhatEndsTooEarlyAndWhere) {
    ByteWriter out;
    out.write(std::uint32_t{1});
    ByteReader in(out.view(), "a snapshot", ByteReader::Origin::Outside);
    in.read<std::uint16_t>();
    EXPECT_EQ(in.read<std::uint64_t>(), 0u);
    ASSERT_FALSE(in.outcome().has_value());
    EXPECT_EQ(in.outcome().error().problem, "a snapshot ends too early: it has 4 bytes, and 8 more are needed at byte 2");
}

TEST(Bytes, WithAWrongCountGiveNoItems) {
    ByteWriter out;
    out.write_count(0xffffffff);
    ByteReader in(out.view(), "a snapshot", ByteReader::Origin::Outside);
    EXPECT_EQ(in.read_count(sizeof(std::uint64_t)), 0u);
    EXPECT_TRUE(in.failed());
}

TEST(BytesDeathTest, OfOurOwnThatEndTooEarlyAreABug) {
    ByteWriter out;
    out.write(std::uint8_t{1});
    ByteReader in(out.view(), "a packet of exports");
    EXPECT_EXIT(in.read<std::uint32_t>(), testing::ExitedWithCode(70), "a packet of exports has 1 bytes, and 4 are read at byte 0");
}

}  // namespace
}  // namespace meld
