// What watches cost while the gradient settles on a cube, and when it has settled: the run with each beside the run with none.
// Usage: bench_watch GRADIENT.meld [SIDE]
#include "runtime/ask/watch/watches.h"
#include "tests/bench/measure.h"

namespace {

using namespace meld;
using namespace meld::bench;

constexpr int kRuns = 5;
constexpr int kIdleTicks = 20'000;

// CPU seconds of a run to its last event, which changes nothing, without setting it up.
double cost(const char* program, const std::string& world, const std::string& body) {
    const auto add = [&](Run& run) {
        if (body.empty()) return;
        front::WatchRule rule{.verb = front::WatchRule::Verb::Never, .asked = {.text = body}, .body = body};
        std::vector<front::WatchRule> rules{std::move(rule)};
        run.simulation->add(need(inspect::Watches::make(run.info(), std::move(rules), stdout)), "watches");
    };
    Run run(program, world, 1, add);
    return run.settle();
}

void measure(const char* title, const char* program, const std::string& world, const std::vector<std::string>& bodies) {
    std::printf("%s\n", title);
    std::vector<std::vector<double>> seconds(bodies.size());
    for (int i = 0; i <= kRuns; ++i)
        for (std::size_t b = 0; b < bodies.size(); ++b) {
            const double one = cost(program, world, bodies[b]);
            // The first is not counted.
            if (i > 0) seconds[b].push_back(one);
        }
    for (std::size_t b = 0; b < bodies.size(); ++b) {
        std::vector<double> ratios;
        for (int i = 0; i < kRuns; ++i) ratios.push_back(seconds[b][static_cast<std::size_t>(i)] / seconds[0][static_cast<std::size_t>(i)]);
        std::printf("  %8.3f s, %5.2f times the run: %s\n", median(seconds[b]), median(ratios), b == 0 ? "nothing" : bodies[b].c_str());
    }
}

}  // namespace

int main(int argc, char** argv) {
    const int side = argc > 2 ? std::atoi(argv[2]) : 100;
    const auto text = fmt::format("lattice = \"cubic\"\n[[body]]\nshape = \"box({0}, {0}, {0})\"\n[facts]\nsource = \"id == 0\"\n", side);
    const auto idle = fmt::format("{}[[event]]\ntick = {}\ntake.source = \"id == 1\"\n", text, kIdleTicks);
    machine_line("CPU seconds and ratios, medians of 5");
    const std::vector<std::string> bodies = {"", "dist(A, D), D < 0", "dist(A, D), neighbor(A, B), dist(B, E), E > D + 1",
                                             "dist(A, D), D > 0, not (neighbor(A, B), dist(B, E), E < D)",
                                             "dist(A, D), D > 0, N = count : { neighbor(A, B), dist(B, E), E < D }, N < 1"};
    measure(fmt::format("{} catoms while they settle", side * side * side).c_str(), argv[1], text, bodies);
    measure(fmt::format("the same and {} ticks in which nothing happens", kIdleTicks).c_str(), argv[1], idle, {bodies[0], bodies[2]});
}
