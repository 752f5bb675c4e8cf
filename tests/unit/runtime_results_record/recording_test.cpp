// What can be seen without reading the file; tests/unit/runtime_results_record/python reads it.
#include "runtime/results/record/recording.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include "runtime/results/record/recording_reader.h"

namespace meld::record {
namespace {

namespace fs = std::filesystem;

class RecordingTest : public testing::Test {
  protected:
    RecordingTest() { fs::create_directories(folder_); }
    ~RecordingTest() override { fs::remove_all(folder_); }
    std::string path(const std::string& name) const { return folder_ / name; }
    std::size_t files() const { return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), {})); }

    std::vector<RecordedPosition> positions_ = {{0, 0, 0}, {1, 0, 0}};
    std::vector<std::uint64_t> ids_ = {4, 7};
    std::vector<std::int64_t> values_ = {1, 2};

  private:
    const fs::path folder_ = fs::temp_directory_path() / ("recording_test_" + std::to_string(getpid()));
};

TEST_F(RecordingTest, LeavesTheFileAndItsSidecar) {
    auto recording = Recording::create(path("a"), {});
    ASSERT_TRUE(recording) << recording.error().message();
    EXPECT_EQ(files(), 3u) << "the recording, and the locks of two files";
    const RecordedArray array = {"dist", RecordedArray::Int64, values_.data(), 1};
    EXPECT_TRUE(recording->step(0, positions_, ids_, {&array, 1}));
    EXPECT_TRUE(recording->close());
    EXPECT_TRUE(fs::exists(path("a")) && fs::exists(path("a.xdmf")));
}

TEST_F(RecordingTest, StepsWithoutChangeCostAlmostNothing) {
    const std::vector<RecordedPosition> positions(20000, {1, 2, 3});
    std::vector<std::uint64_t> ids(20000);
    std::uint64_t state = 1;
    for (std::uint64_t& id : ids) id = state += (state * 2862933555777941757u + 3037000493u) >> 50;
    const auto size_of_steps = [&](int steps) {
        auto recording = Recording::create(path("a"), {});
        for (int step = 0; step < steps; ++step) EXPECT_TRUE(recording->step(step, positions, ids, {}));
        EXPECT_TRUE(recording->close());
        return fs::file_size(path("a"));
    };
    const std::uintmax_t two = size_of_steps(2);
    EXPECT_LT(size_of_steps(100) - two, 1000u);
}

TEST_F(RecordingTest, SidecarIsNeverLargerThanTheRecording) {
    const auto times_in_sidecar = [&](int steps, int changes) {
        auto recording = Recording::create(path("a"), {});
        const RecordedArray arrays[] = {{"one", RecordedArray::Int64, values_.data(), 1}, {"two", RecordedArray::Int64, values_.data(), 1}};
        for (int step = 0; step < steps; ++step) {
            values_[0] = step % changes;
            EXPECT_TRUE(recording->step(step, positions_, ids_, arrays));
        }
        EXPECT_TRUE(recording->close());
        EXPECT_LE(fs::file_size(path("a.xdmf")), fs::file_size(path("a")));
        std::ifstream file(path("a.xdmf"));
        std::vector<int> times;
        const std::string mark = "<Time Value=\"";
        for (std::string line; std::getline(file, line);)
            if (const auto at = line.find(mark); at != std::string::npos) times.push_back(std::stoi(line.substr(at + mark.size())));
        return times;
    };
    EXPECT_EQ(times_in_sidecar(1000, 1), std::vector<int>{0}) << "steps like the one before are left out";
    EXPECT_EQ(times_in_sidecar(4, 4), (std::vector<int>{0, 1, 2, 3}));
    const std::vector<int> some = times_in_sidecar(3000, 3000);
    ASSERT_GT(some.size(), 100u);
    EXPECT_LT(some.size(), 3000u);
    EXPECT_EQ(some.front(), 0);
    EXPECT_EQ(some.back(), 2999);
    for (std::size_t i = 2; i + 1 < some.size(); ++i) EXPECT_EQ(some[i] - some[i - 1], some[1] - some[0]);
}

TEST_F(RecordingTest, SaysThatTheDirectoryIsMissing) {
    const auto recording = Recording::create(path("no/such/a"), {});
    ASSERT_FALSE(recording);
    EXPECT_EQ(recording.error().problem, "cannot write " + path("no/such/a") + ": No such file or directory");
    EXPECT_EQ(recording.error().code, ExitCode::UsageOrWorld);
}

TEST_F(RecordingTest, SaysThatThePathIsADirectory) {
    fs::create_directory(path("a"));
    const auto recording = Recording::create(path("a"), {});
    ASSERT_FALSE(recording);
    EXPECT_NE(recording.error().problem.find("Is a directory"), std::string::npos);
    EXPECT_EQ(files(), 1u);
}

TEST_F(RecordingTest, SaysWhyItCannotBeBegun) {
    const auto recording = Recording::create("/proc/a", {});
    ASSERT_FALSE(recording);
    EXPECT_EQ(recording.error().problem, "cannot write /proc/a: No such file or directory");
}

TEST_F(RecordingTest, ReplacesAnEarlierRecordingWhenItIsWhole) {
    std::ofstream(path("a")) << "old";
    const auto size = [&] { return fs::file_size(path("a")); };
    {
        auto recording = Recording::create(path("a"), {});
        ASSERT_TRUE(recording);
        ASSERT_TRUE(recording->step(0, positions_, ids_, {}));
        EXPECT_EQ(size(), 3u);
        EXPECT_TRUE(recording->close());
        EXPECT_GT(size(), 1000u);
    }
    EXPECT_EQ(files(), 2u);
}

TEST_F(RecordingTest, KeepsAnEarlierRecordingAndWhatItHasItself) {
    std::ofstream(path("a")) << "old";
    {
        auto recording = Recording::create(path("a"), {});
        ASSERT_TRUE(recording->step(0, positions_, ids_, {}));
    }
    EXPECT_EQ(fs::file_size(path("a")), 3u);
    EXPECT_EQ(files(), 2u) << "the old one and the new one; the sidecar comes at the end";
}

TEST_F(RecordingTest, TakesNoStepsAfterItsEnd) {
    auto recording = Recording::create(path("a"), {});
    ASSERT_TRUE(recording->close());
    EXPECT_FALSE(recording->step(0, positions_, ids_, {}));
}

TEST_F(RecordingTest, RefusesNamesThatHdf5WouldSplit) {
    auto recording = Recording::create(path("a"), {});
    const RecordedArray array = {"a/b", RecordedArray::Int64, values_.data(), 1};
    EXPECT_EXIT(static_cast<void>(recording->step(0, positions_, ids_, {&array, 1})), testing::ExitedWithCode(70), "array 'a/b'");
}

// As if another process had written a half of each header, and the other half a moment later.
TEST_F(RecordingTest, WhatIsHalfWrittenIsReadAgain) {
    {
        auto recording = Recording::create(path("a"), {});
        ASSERT_TRUE(recording->step(7, positions_, ids_, {}));
        EXPECT_TRUE(recording->close());
    }
    std::ifstream file(path("a"), std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(file), {}};
    std::string half = whole;
    for (std::size_t at = half.find("OHDR"); at != std::string::npos; at = half.find("OHDR", at + 1)) half[at + 40] ^= 1;
    const auto write = [&](const std::string& bytes) { std::fstream(path("a"), std::ios::binary | std::ios::in | std::ios::out) << bytes; };
    write(half);
    EXPECT_EQ(RecordingReader::open(path("a")).error().code, ExitCode::RecordingRefused);
    // On a machine that has other work the other half may come too late.
    bool read = false;
    for (int trial = 0; trial < 20 && !read; ++trial) {
        write(half);
        const std::jthread other_half([&] {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
            write(whole);
        });
        const auto recording = RecordingReader::open(path("a"));
        read = recording && recording->ticks() == std::vector<std::int64_t>{7};
    }
    EXPECT_TRUE(read);
}

}  // namespace
}  // namespace meld::record
