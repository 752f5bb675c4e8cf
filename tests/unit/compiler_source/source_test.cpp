// Files, lines, places and reading from disk.
#include "compiler/source/source.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

namespace meld::source {
namespace {

TEST(File, CountsLinesAndColumnsFromOne) {
    const File file("a.meld", "ab\ncd\n\nx");
    EXPECT_EQ(file.line_count(), 4u);
    EXPECT_EQ(file.place(0).line, 1u);
    EXPECT_EQ(file.place(0).column, 1u);
    EXPECT_EQ(file.place(4).line, 2u);
    EXPECT_EQ(file.place(4).column, 2u);
    EXPECT_EQ(file.place(7).line, 4u);
}

TEST(File, PlacesTheLineBreakOnTheLineItEnds) {
    const File file("a.meld", "ab\ncd");
    EXPECT_EQ(file.place(2).line, 1u);
    EXPECT_EQ(file.place(2).column, 3u);
    EXPECT_EQ(file.place(5).line, 2u);
    EXPECT_EQ(file.place(5).column, 3u);
}

TEST(File, GivesLinesWithoutTheirEnds) {
    const File file("a.meld", "ab\r\ncd\n\nx");
    EXPECT_EQ(file.line(1), "ab");
    EXPECT_EQ(file.line(2), "cd");
    EXPECT_EQ(file.line(3), "");
    EXPECT_EQ(file.line(4), "x");
}

TEST(File, HasOneEmptyLineWhenEmpty) {
    const File file("a.meld", "");
    EXPECT_EQ(file.line_count(), 1u);
    EXPECT_EQ(file.line(1), "");
    EXPECT_EQ(file.place(0).line, 1u);
}

TEST(Span, JoinsToTheSmallestThatHoldsBoth) {
    const Span joined = Span{0, 5, 9}.to({0, 2, 7});
    EXPECT_EQ(joined.begin, 2u);
    EXPECT_EQ(joined.end, 9u);
}

TEST(FileSet, GivesTheTextOfASpan) {
    FileSet files;
    files.add("a.meld", "first");
    const std::uint32_t second = files.add("b.meld", "p(A).");
    EXPECT_EQ(files.text({second, 2, 3}), "A");
    EXPECT_EQ(files.text({second, 3, 99}), ").");
    EXPECT_EQ(files.text({second, 99, 120}), "");
    EXPECT_EQ(files.file(second).path(), "b.meld");
}

TEST(FileSet, KeepsFilesWhereTheyAre) {
    FileSet files;
    const File* first = &files.file(files.add("a.meld", "x"));
    for (int i = 0; i < 100; ++i) files.add("b.meld", "y");
    EXPECT_EQ(first, &files.file(std::uint32_t{0}));
}

TEST(FileSet, ReadsAFileFromDisk) {
    const auto path = std::filesystem::temp_directory_path() / "claymeld_source_test.meld";
    std::ofstream(path) << "p(A).\n";
    FileSet files;
    const auto index = files.read(path.string());
    ASSERT_TRUE(index.has_value());
    EXPECT_EQ(files.file(*index).text(), "p(A).\n");
    std::filesystem::remove(path);
}

TEST(FileSet, RefusesWhatIsNoReadableFile) {
    FileSet files;
    EXPECT_FALSE(files.read("/no/such/file.meld").has_value());
    EXPECT_FALSE(files.read(std::filesystem::temp_directory_path().string()).has_value());
    EXPECT_FALSE(files.read("/dev/zero").has_value());
    EXPECT_EQ(files.count(), 0u);
}

}  // namespace
}  // namespace meld::source
