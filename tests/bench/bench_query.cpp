// What a question about a run costs: of one catom, and of all. The gradient on a cube. Usage: bench_query GRADIENT.meld [SIDE]
#include <chrono>

#include "runtime/ask/query/query.h"
#include "tests/bench/measure.h"

namespace {

using namespace meld;
using namespace meld::bench;

double wall_ms() { return 1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

// The middle of five.
void measure(Run& run, const char* body) {
    std::vector<double> all;
    std::uint64_t rows = 0;
    for (int i = 0; i < 5; ++i) {
        const double before = wall_ms();
        rows = need(inspect::query(run.subdomain(), body)).rows();
        all.push_back(wall_ms() - before);
    }
    std::printf("  %9.2f ms, %9llu rows: %s\n", median(all), static_cast<unsigned long long>(rows), body);
}

}  // namespace

int main(int argc, char** argv) {
    const int side = argc > 2 ? std::atoi(argv[2]) : 100;
    const auto text = fmt::format("lattice = \"cubic\"\n[[body]]\nshape = \"box({0}, {0}, {0})\"\n[facts]\nsource = \"id == 0\"\n", side);
    machine_line("wall milliseconds, medians of 5");
    Run run(argv[1], text);
    run.settle();
    std::printf("%d catoms\n", side * side * side);
    measure(run, "dist(@42, D)");
    measure(run, "dist(@42, D), neighbor(@42, B), dist(B, E), E < D");
    measure(run, "dist(A, D), D > 100000");
    measure(run, "dist(A, 7)");
    measure(run, "N = count : { dist(A, D), D > 50 }");
    measure(run, "M = max D : { dist(A, D) }");
    measure(run, "dist(A, D), D > 0, not (neighbor(A, B), dist(B, E), E < D)");
    measure(run, "source(S), dist(A, D), dist(B, D), cell(A, X, Y, Z), X = Y, Y = Z, cell(B, X, Y, Z), A <> B");
    measure(run, "dist(A, D)");
}
