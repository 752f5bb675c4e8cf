// What processes say to each other before the first tick, on threads that stand for them.
#include "runtime/driver/run/configuration_agreement.h"

#include <gtest/gtest.h>

#include <functional>
#include <mutex>
#include <vector>

namespace meld::driver {
namespace {

using Statement = Result<std::vector<Claim>>;

// The message of the result that all processes get, "" if they agree.
std::string outcome(int parts, const std::function<Statement(int part)>& say, ExitCode code = ExitCode::UsageOrWorld) {
    std::mutex mutex;
    std::vector<std::string> messages;
    comm::run_threads_as_processes(parts, [&](comm::Communicator& comm) {
        const Result<void> done = agree(comm, say(comm.process()));
        const std::lock_guard lock(mutex);
        messages.push_back(done ? "" : done.error().problem);
        EXPECT_EQ(done ? code : done.error().code, code);
    });
    for (const std::string& message : messages) EXPECT_EQ(message, messages[0]) << "all processes end alike";
    return messages[0];
}

Claim number(const std::string& name, int value) {
    return {.name = name, .shown = std::to_string(value), .hash = static_cast<unsigned>(value)};
}

TEST(Agree, IsSilentWhereAllHaveTheSame) {
    for (const int parts : {1, 2, 5}) EXPECT_EQ(outcome(parts, [](int) { return std::vector{number("--ticks", 7)}; }), "");
}

TEST(Agree, NamesWhatDiffersAndWhere) {
    EXPECT_EQ(outcome(2, [](int part) { return std::vector{number("--ticks", 7), number("the seed", part)}; }),
              "the processes of this run differ in the seed (0 on process 0, 1 on process 1)");
    EXPECT_EQ(outcome(7, [](int part) { return std::vector{number("--ticks", part == 1 || part == 6 ? 1 : 5), number("n", part > 2)}; }),
              "the processes of this run differ in --ticks (5 on processes 0 and 2 to 5, 1 on processes 1 and 6); n (0 on processes 0 to "
              "2, 1 on processes 3 to 6)");
}

TEST(Agree, TellsFilesOfOneNameApart) {
    const auto world = [](int part) { return std::vector{Claim{.name = "the world", .shown = "w.toml", .hash = part == 0 ? 1u : 0xabcu}}; };
    EXPECT_EQ(outcome(2, world),
              "the processes of this run differ in the world (w.toml with hash 0000000000000001 on process 0, w.toml with hash "
              "0000000000000abc on process 1)");
}

TEST(Agree, EndsWithTheCodeOfWhatDiffers) {
    const auto module = [](int part) {
        return std::vector{number("n", part),
                           Claim{.name = "the module", .shown = "m", .hash = static_cast<unsigned>(part), .code = ExitCode::ModuleRefused}};
    };
    EXPECT_NE(outcome(2, module, ExitCode::ModuleRefused), "");
}

// The others wait for it, so they must hear of it.
TEST(Agree, TellsAllOfAnErrorThatOneMet) {
    const auto one = [](int part) { return part == 2 ? Statement(fail("there is no file w.toml")) : std::vector{number("n", 1)}; };
    EXPECT_EQ(outcome(3, one), "on process 2: there is no file w.toml");
    EXPECT_EQ(outcome(3, [](int) { return Statement(fail("there is no file w.toml")); }), "there is no file w.toml");
}

}  // namespace
}  // namespace meld::driver
