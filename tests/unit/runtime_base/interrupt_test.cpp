#include "runtime/base/process/interrupt.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>

#include "runtime/base/files/output_file.h"
#include "runtime/base/temporary_files.h"

namespace meld {
namespace {

namespace fs = std::filesystem;
using interrupt::Answer;
using interrupt::Answering;
using interrupt::Undivided;

constexpr int kTerminated = 143;

class InterruptTest : public testing::Test {
  protected:
    InterruptTest() { fs::create_directories(folder_); }
    ~InterruptTest() override { fs::remove_all(folder_); }
    std::string path(const std::string& name) const { return folder_ / name; }
    bool empty() const { return fs::is_empty(folder_); }

  private:
    const fs::path folder_ = fs::temp_directory_path() / ("interrupt_test_" + std::to_string(getpid()));
};

void handle() { interrupt::handle({SIGTERM, SIGUSR1}, {SIGUSR1}); }

TEST_F(InterruptTest, LeavesNothingThatIsNoResult) {
    const auto run = [&] {
        handle();
        auto facts = OutputFile::open(path("facts"), Appears::Whole);
        auto digest = OutputFile::open(path("digest"), Appears::AtOnce);
        auto begun = OutputFile::open(path("begun"), Appears::OnceReadable);
        auto recording = OutputFile::open(path("recording"), Appears::OnceReadable);
        facts->write(std::string(100'000, 'x'));
        begun->write("head");
        // Nobody has said that anything is in it.
        const bool appeared = begun->flush() && recording->place() && recording->appear();
        if (appeared && fs::exists(path("digest")) && fs::exists(path("recording"))) raise(SIGTERM);
    };
    EXPECT_EXIT(run(), testing::ExitedWithCode(kTerminated), "");
    EXPECT_TRUE(empty());
}

TEST_F(InterruptTest, TakesFoldersAlong) {
    const auto run = [&] {
        handle();
        const Leftover outer(path("outer")), inner(path("outer/inner")), file(path("outer/inner/file"));
        fs::create_directories(path("outer/inner"));
        std::ofstream(path("outer/inner/file")) << "text";
        raise(SIGTERM);
    };
    EXPECT_EXIT(run(), testing::ExitedWithCode(kTerminated), "");
    EXPECT_TRUE(empty());
}

TEST_F(InterruptTest, HoldsSignalsUntilTheyAreHandled) {
    const auto run = [&] {
        interrupt::hold({SIGTERM});
        raise(SIGTERM);
        std::ofstream(path("held")) << "text";
        const Leftover held(path("held"));
        handle();
    };
    EXPECT_EXIT(run(), testing::ExitedWithCode(kTerminated), "");
    EXPECT_TRUE(empty());
}

TEST_F(InterruptTest, CanEndByTheSignalItself) {
    const auto run = [&] {
        handle();
        interrupt::end_by_signal();
        auto facts = OutputFile::open(path("facts"), Appears::Whole);
        raise(SIGTERM);
    };
    EXPECT_EXIT(run(), testing::KilledBySignal(SIGTERM), "");
    EXPECT_TRUE(empty());
}

TEST_F(InterruptTest, LeavesResults) {
    const auto run = [&] {
        handle();
        std::ofstream(path("old.log")) << "old";
        auto digest = OutputFile::open(path("digest"), Appears::AtOnce);
        auto recording = OutputFile::open(path("recording"), Appears::OnceReadable);
        auto beside = OutputFile::open(path("old.log"), Appears::AtOnce);
        auto facts = OutputFile::open(path("facts"), Appears::Whole);
        digest->write("1\n");
        beside->write("1\n");
        bool done = digest->flush() && beside->flush() && recording->place() && recording->appear() && facts->commit();
        recording->note_written();
        if (done) raise(SIGTERM);
    };
    EXPECT_EXIT(run(), testing::ExitedWithCode(kTerminated), "");
    for (const char* name : {"digest", "recording", "old.log", "facts"}) EXPECT_TRUE(fs::remove(path(name))) << name;
    EXPECT_EQ(std::distance(fs::directory_iterator(path("")), {}), 1) << "what has grown beside an older one";
}

TEST_F(InterruptTest, WaitsForTheEndOfWhatIsUndivided) {
    const auto run = [&] {
        handle();
        const Undivided outer;
        {
            const Undivided inner;
            raise(SIGTERM);
        }
        std::ofstream(path("reached")) << "yes";
    };
    EXPECT_EXIT(run(), testing::ExitedWithCode(kTerminated), "");
    EXPECT_TRUE(fs::exists(path("reached")));
}

TEST_F(InterruptTest, EndsWhenTheTimeIsUpAsAtASignal) {
    constexpr double kSoon_s = 0.001;
    const auto at_once = [] {
        handle();
        interrupt::set_last_words("interrupted");
        const interrupt::TimeLimit limit("it", kSoon_s);
        while (true) pause();
    };
    EXPECT_EXIT(at_once(), testing::ExitedWithCode(4), "^it: the time limit of 0.001 s has passed. Raise --timeout\n$");
    const auto orderly = [] {
        handle();
        const Answering soon(Answer::Soon);
        const interrupt::TimeLimit limit("it", kSoon_s);
        while (!interrupt::time_is_up()) pause();
        std::_Exit(interrupt::exit_code());
    };
    EXPECT_EXIT(orderly(), testing::ExitedWithCode(4), "^$");
    const auto late = [] {
        handle();
        const Answering soon(Answer::Soon);
        const interrupt::TimeLimit limit("it", kSoon_s);
        while (true) pause();
    };
    EXPECT_EXIT(late(), testing::ExitedWithCode(4), "") << "after the patience with a signal";
}

TEST_F(InterruptTest, CountsARepeatedSignalOnce) {
    const auto run = [](int first, int second) {
        handle();
        const Answering patiently(Answer::Patiently);
        raise(first);
        raise(second);
        std::_Exit(interrupt::received());
    };
    EXPECT_EXIT(run(SIGTERM, SIGTERM), testing::ExitedWithCode(kTerminated), "");
    EXPECT_EXIT(run(SIGUSR1, SIGTERM), testing::ExitedWithCode(130), "");
    EXPECT_EXIT(run(SIGUSR1, SIGUSR1), testing::ExitedWithCode(SIGUSR1), "");
    EXPECT_EXIT(run(SIGTERM, SIGUSR1), testing::ExitedWithCode(SIGTERM), "");
}

}  // namespace
}  // namespace meld
