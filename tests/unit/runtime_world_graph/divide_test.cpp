#include "runtime/world/graph/divide.h"

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>

#include "runtime/base/terminal/log.h"
#include "runtime/world/graph/generate.h"

// How METIS leaves where it fails.
extern "C" void gk_errexit(int signal, const char* format, ...);

namespace {
// What is to happen when METIS asks for a random number the next time.
void (*in_metis)() = nullptr;
}  // namespace

// In place of the C library's: METIS calls it in the midst of its work.
extern "C" int rand() noexcept {
    static int (*const real)() = reinterpret_cast<int (*)()>(dlsym(RTLD_NEXT, "rand"));
    if (void (*const now)() = std::exchange(in_metis, nullptr)) now();
    return real();
}

namespace meld::graph {
namespace {

volatile sig_atomic_t asked = 0;

void ask() { raise(SIGTERM); }
void fail() { gk_errexit(SIGTERM, "no way is found, of %d", 7); }

// Divides a graph; while METIS does, `what` happens. Whether a SIGTERM reached the process is in `asked`.
std::vector<std::int32_t> divide_while(void (*what)(), const Graph& graph) {
    asked = 0;
    struct sigaction before{}, action{};
    action.sa_handler = [](int) { asked = 1; };
    sigaction(SIGTERM, &action, &before);
    in_metis = what;
    std::vector<std::int32_t> parts = divide(graph, 4);
    EXPECT_EQ(in_metis, nullptr) << "METIS asked for no random number";
    sigaction(SIGTERM, &before, nullptr);
    return parts;
}

class Divide : public testing::Test {
  protected:
    void SetUp() override {
        log::set_output([this](std::string_view line) { said_ += line; });
    }
    void TearDown() override { log::set_output({}); }

    const Graph graph_ = *generate("scale_free(2000, 8)", 1);
    std::string said_;
};

// METIS takes SIGTERM for an error of its own while it runs.
TEST_F(Divide, ARequestToEndReachesTheProcess) {
    EXPECT_EQ(divide_while(ask, graph_).size(), graph_.nodes());
    EXPECT_EQ(asked, 1);
    EXPECT_EQ(said_, "");
}

TEST_F(Divide, AFailureOfMetisIsNoRequestToEnd) {
    std::FILE* const before = stderr;
    const std::vector<std::int32_t> parts = divide_while(fail, graph_);
    EXPECT_EQ(stderr, before);
    EXPECT_EQ(asked, 0);
    EXPECT_EQ(
        said_,
        "warning: METIS cannot divide the graph (no way is found, of 7): its nodes are divided in order, by which more links may lead "
        "to other processes\n");
    ASSERT_EQ(parts.size(), graph_.nodes());
    EXPECT_TRUE(std::ranges::is_sorted(parts));
    EXPECT_EQ(parts.back(), 3);
}

}  // namespace
}  // namespace meld::graph
