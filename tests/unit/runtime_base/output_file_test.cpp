// The rest, with devices, FIFOs, owners and full disks, is in tests/cli/outputs_test.py.
#include "runtime/base/files/output_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "runtime/base/files/output_paths.h"

namespace meld {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class OutputFileTest : public testing::Test {
  protected:
    OutputFileTest() { fs::create_directories(folder_); }
    ~OutputFileTest() override { fs::remove_all(folder_); }
    std::string path(const std::string& name) const { return folder_ / name; }
    void put(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }
    std::string text(const std::string& name) const {
        std::ifstream file(path(name));
        return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    }
    std::size_t files() const { return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), {})); }

  private:
    const fs::path folder_ = fs::temp_directory_path() / ("output_file_test_" + std::to_string(getpid()));
};

TEST_F(OutputFileTest, AppearsWhenItIsWhole) {
    {
        auto file = OutputFile::open(path("a"), Appears::Whole);
        ASSERT_TRUE(file) << file.error().message();
        file->write("new");
        EXPECT_TRUE(file->flush());
        EXPECT_FALSE(fs::exists(path("a")));
        EXPECT_TRUE(file->commit());
    }
    EXPECT_EQ(text("a"), "new");
    EXPECT_EQ(files(), 1u);
}

TEST_F(OutputFileTest, LeavesEverythingAsItWasIfItIsNotCommitted) {
    put("a", "old");
    for (const char* name : {"a", "b"}) {
        auto file = OutputFile::open(path(name), Appears::Whole);
        ASSERT_TRUE(file);
        file->write(std::string(100'000, 'x'));
    }
    EXPECT_EQ(text("a"), "old");
    EXPECT_EQ(files(), 1u);
}

TEST_F(OutputFileTest, GrowsAtItsPathWhereNothingIsLost) {
    {
        auto file = OutputFile::open(path("a"), Appears::AtOnce);
        ASSERT_TRUE(file);
        file->write("one\n");
        EXPECT_TRUE(file->flush());
        EXPECT_EQ(text("a"), "one\n");
        file->write("two\n");
    }
    EXPECT_EQ(text("a"), "one\ntwo\n") << "what has been written stays";
    {
        ASSERT_TRUE(OutputFile::open(path("b"), Appears::AtOnce));
    }
    EXPECT_FALSE(fs::exists(path("b"))) << "nothing has been written";
}

TEST_F(OutputFileTest, TakesItsPathOnceItCanBeRead) {
    {
        auto file = OutputFile::open(path("a"), Appears::OnceReadable);
        ASSERT_TRUE(file);
        file->write("head\n");
        EXPECT_TRUE(file->flush());
        EXPECT_FALSE(fs::exists(path("a")));
        EXPECT_TRUE(file->appear());
        EXPECT_EQ(text("a"), "head\n");
        EXPECT_EQ(file->place(), path("a"));
        file->write("result\n");
    }
    EXPECT_EQ(text("a"), "head\nresult\n");
    {
        auto file = OutputFile::open(path("a"), Appears::OnceReadable);
        ASSERT_TRUE(file);
        file->write("new");
        EXPECT_TRUE(file->appear());
        EXPECT_EQ(text("a"), "head\nresult\n") << "it is kept until the new one is whole";
        EXPECT_TRUE(file->commit());
    }
    EXPECT_EQ(text("a"), "new");
    {
        ASSERT_TRUE(OutputFile::open(path("b"), Appears::OnceReadable)->place());
    }
    EXPECT_EQ(files(), 1u);
}

TEST_F(OutputFileTest, GrowsBesideWhatIsThere) {
    put("a.log", "old");
    auto file = OutputFile::open(path("a.log"), Appears::AtOnce);
    ASSERT_TRUE(file);
    file->write("new");
    ASSERT_TRUE(file->flush());
    EXPECT_EQ(text("a.log"), "old");
    const auto place = file->place();
    ASSERT_TRUE(place);
    EXPECT_EQ(fs::path(*place).extension(), ".log");
    EXPECT_TRUE(file->commit());
    EXPECT_EQ(text("a.log"), "new");
    EXPECT_FALSE(fs::exists(*place));
}

TEST_F(OutputFileTest, ReplacesItsEnd) {
    auto file = OutputFile::open(path("a"), Appears::AtOnce);
    ASSERT_TRUE(file);
    file->write("<a></a>");
    file->replace_from(3, "text</a>");
    file->replace_from(3, "b</a>");
    ASSERT_TRUE(file->commit());
    EXPECT_EQ(text("a"), "<a>b</a>");
}

TEST_F(OutputFileTest, HoldsSmallAndLargePiecesInOrder) {
    std::string all;
    auto file = OutputFile::open(path("a"), Appears::Whole, Durability::Machine);
    ASSERT_TRUE(file);
    // Those below the buffer's size wait; more than the disk is told at once; a piece that is written at once comes after what waits.
    for (const std::size_t size : {10, 70'000, 3, 65'535, 1, 65'536, 9'000'000, 5, 12'000'000, 100}) {
        all += std::string(size, static_cast<char>('a' + all.size() % 23));
        file->write(std::string_view(all).substr(all.size() - size));
        EXPECT_EQ(file->size(), all.size());
    }
    EXPECT_TRUE(file->commit());
    EXPECT_TRUE(text("a") == all);
}

TEST_F(OutputFileTest, HasOneWriterAtATime) {
    auto first = OutputFile::open(path("a"), Appears::Whole);
    ASSERT_TRUE(first);
    // Locks are of open files, so that a process keeps out even itself.
    const auto second = OutputFile::open(path("./a"), Appears::AtOnce);
    ASSERT_FALSE(second);
    EXPECT_THAT(second.error().problem, HasSubstr("process " + std::to_string(getpid())));
    ASSERT_TRUE(first->commit());
    {
        const OutputFile gone = std::move(*first);
    }
    EXPECT_TRUE(OutputFile::open(path("a"), Appears::Whole));
}

// A process that is killed while it writes.
void write_and_be_killed(const std::string& path, Appears appears) {
    const pid_t child = fork();
    if (child == 0) {
        auto file = OutputFile::open(path, appears);
        file->write(std::string(100'000, 'x'));
        static_cast<void>(file->flush());
        kill(getpid(), SIGKILL);
    }
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
}

TEST_F(OutputFileTest, RemovesWhatAKilledProcessHasLeftOfAWholeFile) {
    for (const char* name : {"a", "a.b.txt"}) {
        write_and_be_killed(path(name), Appears::Whole);
        EXPECT_EQ(files(), 2u) << name;
        {
            auto file = OutputFile::open(path(name), Appears::Whole);
            ASSERT_TRUE(file) << file.error().message();
            EXPECT_EQ(files(), 1u) << name;
        }
        EXPECT_EQ(files(), 0u) << name;
    }
}

TEST_F(OutputFileTest, KeepsWhatAKilledProcessHasLeftOfAFileThatGrew) {
    put("a", "old");
    write_and_be_killed(path("a"), Appears::AtOnce);
    EXPECT_TRUE(OutputFile::open(path("a"), Appears::Whole));
    EXPECT_EQ(files(), 2u);
}

TEST_F(OutputFileTest, RemovesNothingElseThatALockNames) {
    put("b", "of somebody else");
    fs::create_directory(path("c"));
    put("c/a.part-0123456789abcdef", "of somebody else");
    for (const char* noted : {"b", "../b", "c/a.part-0123456789abcdef", "a.part-0123456789abcdeg", "a.part-0123456789abcde", "", "a"}) {
        put(".a.claymeld-lock", std::string("1\n") + noted + "\n");
        EXPECT_TRUE(OutputFile::open(path("a"), Appears::Whole)) << noted;
        EXPECT_EQ(files(), 2u) << noted;
        EXPECT_TRUE(fs::exists(path("c/a.part-0123456789abcdef"))) << noted;
    }
    put("a.part-0123456789abcdef", "left");
    put(".a.claymeld-lock", "1\na.part-0123456789abcdef\n");
    EXPECT_TRUE(OutputFile::open(path("a"), Appears::Whole));
    EXPECT_EQ(files(), 2u);
}

TEST_F(OutputFileTest, FollowsLinksToWhatIsNotThereYet) {
    fs::create_directory(path("there"));
    fs::create_symlink("there/b", path("a"));
    ASSERT_TRUE(write_file(path("a"), "text"));
    EXPECT_TRUE(fs::is_symlink(path("a")));
    EXPECT_EQ(text("there/b"), "text");
    fs::create_symlink("d", path("c"));
    fs::create_symlink("c", path("d"));
    EXPECT_THAT(write_file(path("c"), "").error().problem, HasSubstr("symbolic links"));
}

TEST_F(OutputFileTest, TellsWhatIsWrong) {
    EXPECT_THAT(write_file(path("no/a"), "").error().message(), HasSubstr("No such file or directory"));
    EXPECT_THAT(write_file(path("."), "").error().problem, HasSubstr("Is a directory"));
    const auto full = write_file("/dev/full", "text");
    ASSERT_FALSE(full);
    EXPECT_EQ(full.error().problem, "cannot write /dev/full: No space left on device");
    EXPECT_EQ(full.error().code, ExitCode::LimitHit);
    EXPECT_TRUE(write_file("/dev/null", "text"));
}

TEST_F(OutputFileTest, ReservesSpaceAndGivesBackWhatItDoesNotNeed) {
    constexpr std::uint64_t most = 8 << 20;
    const auto blocks_bytes = [&] {
        struct stat status{};
        EXPECT_EQ(stat(path("a").c_str(), &status), 0);
        return static_cast<std::uint64_t>(status.st_blocks) * 512;
    };
    auto file = OutputFile::open(path("a"), Appears::Whole);
    ASSERT_TRUE(file);
    ASSERT_TRUE(file->reserve(most));
    file->write("text");
    ASSERT_TRUE(file->commit());
    EXPECT_EQ(text("a"), "text");
    EXPECT_LT(blocks_bytes(), most);
    auto larger = OutputFile::open(path("b"), Appears::Whole);
    ASSERT_TRUE(larger);
    const auto no_disk_is_so_large = larger->reserve(std::uint64_t{1} << 62);
    ASSERT_FALSE(no_disk_is_so_large);
    EXPECT_EQ(no_disk_is_so_large.error().code, ExitCode::LimitHit);
}

TEST_F(OutputFileTest, GoesOnWithWhatAnEarlierProcessWrote) {
    put("a", "one two three");
    {
        auto file = OutputFile::reopen(path("a"), path("a"), 7, Durability::Process);
        ASSERT_TRUE(file) << file.error().message();
        EXPECT_EQ(*file->read_end(3), "two");
        EXPECT_EQ(text("a"), "one two three");
        file->replace_from(7, " 3");
        EXPECT_TRUE(file->sync());
    }
    EXPECT_EQ(text("a"), "one two 3");
    const auto shorter = OutputFile::reopen(path("a"), path("a"), 10, Durability::Process);
    ASSERT_FALSE(shorter);
    EXPECT_THAT(shorter.error().problem, HasSubstr("it is shorter than it was"));
    EXPECT_EQ(text("a"), "one two 3");
    EXPECT_THAT(OutputFile::reopen(path("b"), path("b"), 0, Durability::Process).error().problem, HasSubstr("it is gone"));
}

TEST_F(OutputFileTest, LongNamesLeaveRoomForThoseBeside) {
    const std::string name = std::string(240, 'n') + ".extension";
    put(name, "old");
    ASSERT_TRUE(write_file(path(name), "new"));
    EXPECT_EQ(text(name), "new");
    EXPECT_EQ(files(), 1u);
}

TEST_F(OutputFileTest, PathsThatAreOneFileAreFound) {
    put("a", "");
    fs::create_hard_link(path("a"), path("b"));
    const auto clash = [&](const std::string& first, const std::string& second, NamedPath::Use use = NamedPath::Written) {
        const std::vector<NamedPath> paths = {{"--one", first, use}, {"--two", second, use}};
        const auto distinct = check_distinct(paths);
        return distinct ? "" : distinct.error().problem;
    };
    EXPECT_EQ(clash(path("a"), path("b")), "--one and --two are the same file, " + path("b"));
    EXPECT_NE(clash(path("x"), path("./x")), "");
    EXPECT_EQ(clash(path("a"), path("x")), "");
    EXPECT_EQ(clash("", ""), "");
    EXPECT_EQ(clash("/dev/null", "/dev/null"), "");
    EXPECT_EQ(clash("-", "/dev/stdout"), "--one and --two both write to standard output");
    EXPECT_EQ(clash(path("a"), path("a"), NamedPath::Read), "");
}

}  // namespace
}  // namespace meld
