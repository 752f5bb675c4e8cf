#include "runtime/base/files/line_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <vector>

namespace meld {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class LineReaderOf : public testing::Test {
  protected:
    void TearDown() override { std::filesystem::remove(path_); }
    std::string write(const std::string& text) const {
        std::ofstream(path_, std::ios::binary) << text;
        return path_;
    }
    static std::vector<std::string> rest(LineReader& lines) {
        std::vector<std::string> all;
        for (std::string line; lines.next(line);) all.push_back(line);
        return all;
    }

    const std::string path_ = testing::TempDir() + "claymeld-lines-" + std::to_string(getpid());
};

TEST_F(LineReaderOf, GivesLinesAndTheirPlaces) {
    LineReader lines(write("one\n\nthree\n"));
    std::string line;
    ASSERT_TRUE(lines.next(line));
    EXPECT_EQ(lines.number(), 1U);
    EXPECT_EQ(lines.offset(), 4U);
    EXPECT_THAT(rest(lines), ElementsAre("", "three"));
    EXPECT_TRUE(lines.outcome().has_value());
    lines.seek(4, 1);
    EXPECT_THAT(rest(lines), ElementsAre("", "three"));
    EXPECT_EQ(lines.number(), 3U);
}

TEST_F(LineReaderOf, KnowsALastLineWithoutAnEnd) {
    LineReader lines(write("one\ntwo"));
    std::string line;
    ASSERT_TRUE(lines.next(line));
    EXPECT_TRUE(lines.ended());
    ASSERT_TRUE(lines.next(line));
    EXPECT_EQ(line, "two");
    EXPECT_FALSE(lines.ended());
}

// A folder can be opened, and its first line cannot be read.
TEST_F(LineReaderOf, TellsAnErrorFromTheEnd) {
    LineReader folder(testing::TempDir()), nowhere(path_ + "/nowhere");
    for (LineReader* lines : {&folder, &nowhere}) {
        EXPECT_THAT(rest(*lines), ElementsAre());
        ASSERT_FALSE(lines->outcome().has_value());
        EXPECT_THAT(lines->outcome().error().problem, HasSubstr("cannot read " + lines->path() + ": "));
    }
}

}  // namespace
}  // namespace meld
