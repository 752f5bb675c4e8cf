#include "runtime/graph/divide.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/time.h>

#include "runtime/graph/generate.h"

namespace meld::graph {
namespace {

volatile sig_atomic_t asked = 0;

void ask(int) { raise(SIGTERM); }
void note(int) { asked = 1; }

// METIS takes SIGTERM for an error of its own while it runs.
TEST(Divide, ARequestToEndReachesTheProcess) {
    const Graph graph = *generate("scale_free(20000, 8)", 1);
    struct sigaction before_term{}, before_alarm{}, action{};
    action.sa_handler = note;
    sigaction(SIGTERM, &action, &before_term);
    action.sa_handler = ask;
    sigaction(SIGALRM, &action, &before_alarm);
    // Soon after METIS has begun, which takes some tenths of a second.
    const itimerval soon{{0, 0}, {0, 5'000}};
    setitimer(ITIMER_REAL, &soon, nullptr);
    const std::vector<std::int32_t> parts = divide(graph, 4);
    setitimer(ITIMER_REAL, nullptr, nullptr);
    sigaction(SIGTERM, &before_term, nullptr);
    sigaction(SIGALRM, &before_alarm, nullptr);
    EXPECT_EQ(asked, 1);
    EXPECT_EQ(parts.size(), graph.nodes());
}

}  // namespace
}  // namespace meld::graph
