#include "runtime/base/units.h"

#include <gtest/gtest.h>

#include <limits>

namespace meld {
namespace {

TEST(Units, ReadNumbersWithSuffixes) {
    EXPECT_EQ(parse_number("2M").value(), 2e6);
    EXPECT_EQ(parse_number("1.5k").value(), 1500);
    EXPECT_EQ(parse_number(" -3 Ki ").value(), -3072);
    EXPECT_EQ(parse_number("2.5e-3").value(), 2.5e-3);
}

TEST(Units, ReadCountsExactly) {
    EXPECT_EQ(parse_count("0").value(), 0u);
    EXPECT_EQ(parse_count("2M").value(), 2'000'000u);
    EXPECT_EQ(parse_count("1.5k").value(), 1500u);
    EXPECT_EQ(parse_count("0.1k").value(), 100u);
    EXPECT_EQ(parse_count("1e6").value(), 1'000'000u);
    EXPECT_EQ(parse_count("18446744073709551615").value(), std::numeric_limits<std::uint64_t>::max());
    EXPECT_EQ(parse_count("9007199254740993").value(), 9007199254740993u);
}

TEST(Units, ReadBytes) {
    EXPECT_EQ(parse_bytes("16GiB").value(), std::uint64_t{16} << 30);
    EXPECT_EQ(parse_bytes("1.5 MB").value(), 1'500'000u);
    EXPECT_EQ(parse_bytes("512").value(), 512u);
    EXPECT_EQ(parse_bytes("512B").value(), 512u);
    EXPECT_EQ(parse_bytes("1.3GiB").value(), 1'395'864'371u);
}

TEST(Units, ReadDurations) {
    EXPECT_EQ(parse_duration("90").value(), 90);
    EXPECT_EQ(parse_duration("250ms").value(), 0.25);
    EXPECT_EQ(parse_duration("1.5 h").value(), 5400);
    EXPECT_EQ(parse_duration("2min").value(), 120);
}

TEST(Units, RefuseWhatIsNotANumberAndSayWhy) {
    EXPECT_EQ(parse_count("many").error().problem, "'many' is not a count");
    EXPECT_EQ(parse_count("").error().problem, "'' is not a count");
    EXPECT_EQ(parse_count("-1").error().problem, "'-1' is negative, but a count cannot be");
    EXPECT_EQ(parse_count("1.5").error().problem, "'1.5' is not a whole number, but a count is one");
    EXPECT_EQ(parse_count("2X").error().problem, "'2X' has the unknown suffix 'X'");
    EXPECT_EQ(parse_count("18446744073709551616").error().problem, "'18446744073709551616' is too large for a count");
    EXPECT_EQ(parse_count("99999P").error().problem, "'99999P' is too large for a count");
    EXPECT_EQ(parse_count("1e999").error().problem, "'1e999' is out of range for a count");
    EXPECT_FALSE(parse_count("nan"));
    EXPECT_FALSE(parse_number("inf"));
    EXPECT_FALSE(parse_number("1 2"));
    EXPECT_FALSE(parse_bytes("B"));
    EXPECT_FALSE(parse_duration("-1s"));
    EXPECT_FALSE(parse_duration("3 fortnights"));
}

TEST(Units, FormatBytes) {
    EXPECT_EQ(format_bytes(0), "0 B");
    EXPECT_EQ(format_bytes(512), "512 B");
    EXPECT_EQ(format_bytes(12'897'485), "12.3 MiB");
    EXPECT_EQ(format_bytes(std::uint64_t{3} << 40), "3 TiB");
    EXPECT_EQ(format_bytes(std::numeric_limits<std::uint64_t>::max()), "16 EiB");
}

TEST(Units, FormatCounts) {
    EXPECT_EQ(format_count(0), "0");
    EXPECT_EQ(format_count(950), "950");
    EXPECT_EQ(format_count(1'200'000), "1.2 M");
    EXPECT_EQ(format_count(12'000), "12 k");
    EXPECT_EQ(format_count(999.9), "1 k");
    EXPECT_EQ(format_count(0.25), "0.25");
    EXPECT_EQ(format_count(8e27), "8e+27");
    EXPECT_EQ(format_count(std::numeric_limits<double>::infinity()), "inf");
}

TEST(Units, FormatDurations) {
    EXPECT_EQ(format_duration(0), "0 ns");
    EXPECT_EQ(format_duration(0.0012), "1.2 ms");
    EXPECT_EQ(format_duration(35), "35 s");
    EXPECT_EQ(format_duration(59.96), "1 min 00 s");
    EXPECT_EQ(format_duration(245), "4 min 05 s");
    EXPECT_EQ(format_duration(7620), "2 h 07 min");
    EXPECT_EQ(format_duration(3 * 86400 + 4 * 3600), "3 d 04 h");
    EXPECT_EQ(format_duration(std::numeric_limits<double>::quiet_NaN()), "?");
}

}  // namespace
}  // namespace meld
