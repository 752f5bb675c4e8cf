#include "runtime/base/process/copied_process.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <string>
#include <utility>

namespace meld {
namespace {

using Signals = CopiedProcess::Signals;

// All that comes through a pipe until nobody holds its other end.
std::string read_to_end(int pipe) {
    std::string all;
    char buffer[256];
    for (ssize_t n = 0; (n = read(pipe, buffer, sizeof buffer)) != 0;) {
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return "?";
        all.append(buffer, static_cast<std::size_t>(n));
    }
    return all;
}

TEST(CopiedProcess, AnswersThroughAPipeAndLeavesAFile) {
    for (const Signals signals : {Signals::Shared, Signals::Apart}) {
        int seen = 1;
        auto copy = CopiedProcess::start(
            [&](int pipe, int file) {
                seen = 2;
                write_all(file, std::string(100'000, 'f'));
                write_all(pipe, "answer");
            },
            signals);
        ASSERT_TRUE(copy) << copy.error().message();
        EXPECT_EQ(read_to_end(copy->pipe()), "answer");
        EXPECT_EQ(copy->end().status, 0);
        EXPECT_EQ(read_from_start(copy->file()), std::string(100'000, 'f'));
        EXPECT_EQ(seen, 1);
    }
}

TEST(CopiedProcess, SaysHowItEnded) {
    for (const int signal : {SIGSEGV, SIGKILL, 0}) {
        auto copy = CopiedProcess::start(
            [&](int, int) {
                ::signal(SIGSEGV, SIG_DFL);
                signal > 0 ? static_cast<void>(raise(signal)) : _exit(7);
            },
            Signals::Shared);
        ASSERT_TRUE(copy) << copy.error().message();
        const int status = copy->end().status;
        if (signal > 0) {
            ASSERT_TRUE(WIFSIGNALED(status));
            EXPECT_EQ(WTERMSIG(status), signal);
        } else {
            EXPECT_EQ(WEXITSTATUS(status), 7);
        }
    }
}

TEST(CopiedProcess, ReadsNothing) {
    auto copy = CopiedProcess::start(
        [](int pipe, int) {
            char c = 0;
            write_all(pipe, read(STDIN_FILENO, &c, 1) == 0 ? "nothing" : "something");
        },
        Signals::Shared);
    ASSERT_TRUE(copy) << copy.error().message();
    EXPECT_EQ(read_to_end(copy->pipe()), "nothing");
}

// The pipe ends when the last process that holds it does.
TEST(CopiedProcess, IsKilledWithWhatItHasStarted) {
    int watched[2];
    ASSERT_EQ(pipe(watched), 0);
    {
        auto copy = CopiedProcess::start(
            [&](int pipe, int) {
                const bool original = fork() != 0;
                if (original) write_all(pipe, "x");
                while (true) pause();
            },
            Signals::Apart);
        ASSERT_TRUE(copy) << copy.error().message();
        char c = 0;
        ASSERT_EQ(read(copy->pipe(), &c, 1), 1);
        EXPECT_FALSE(copy->ended().has_value());
    }
    close(watched[1]);
    EXPECT_EQ(read_to_end(watched[0]), "");
    close(watched[0]);
}

TEST(CopiedProcess, EndsWithTheOneThatWantsIt) {
    int watched[2];
    ASSERT_EQ(pipe(watched), 0);
    auto middle = CopiedProcess::start(
        [&](int, int) {
            auto inner = CopiedProcess::start(
                [](int pipe, int) {
                    write_all(pipe, "x");
                    while (true) pause();
                },
                Signals::Shared);
            char c = 0;
            if (inner && read(inner->pipe(), &c, 1) == 1) _exit(0);
            _exit(1);
        },
        Signals::Shared);
    ASSERT_TRUE(middle) << middle.error().message();
    EXPECT_EQ(middle->end().status, 0);
    close(watched[1]);
    EXPECT_EQ(read_to_end(watched[0]), "");
    close(watched[0]);
}

TEST(CopiedProcess, SaysWhatThereIsNoneOf) {
    rlimit before{};
    ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
    // The least descriptors that are free.
    const int next = dup(STDIN_FILENO);
    ASSERT_GE(next, 0);
    close(next);
    for (const auto& [left, what] : {std::pair(0, "cannot make a file in memory"), {1, "cannot make a pipe"}}) {
        set_limit(RLIMIT_NOFILE, static_cast<std::uint64_t>(next + left));
        const auto copy = CopiedProcess::start([](int, int) {}, Signals::Shared);
        set_limit(RLIMIT_NOFILE, before.rlim_cur);
        ASSERT_FALSE(copy);
        EXPECT_EQ(copy.error().problem.find(what), 0u) << copy.error().problem;
    }
}

TEST(CopiedProcess, IsMoved) {
    auto first = CopiedProcess::start([](int pipe, int) { write_all(pipe, "first"); }, Signals::Shared);
    auto second = CopiedProcess::start([](int pipe, int) { write_all(pipe, "second"); }, Signals::Apart);
    ASSERT_TRUE(first && second);
    CopiedProcess moved = std::move(*first);
    moved = std::move(*second);
    EXPECT_EQ(read_to_end(moved.pipe()), "second");
    EXPECT_EQ(moved.end().status, 0);
}

}  // namespace
}  // namespace meld
