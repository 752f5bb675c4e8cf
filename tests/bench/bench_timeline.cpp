// What it costs to be able to go back: a snapshot in memory of a quiet ensemble, the first and one that shares its chunks, and one step
// back. The gradient on a cube. Usage: bench_timeline GRADIENT.meld [SIDE]
#include <chrono>

#include "runtime/results/timeline/timeline.h"
#include "tests/bench/measure.h"

namespace {

using namespace meld;
using namespace meld::bench;

double wall_ms() { return 1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

template <class Do>
double median_ms(int times, const Do& act) {
    std::vector<double> all;
    for (int i = 0; i < times; ++i) {
        const double before = wall_ms();
        act(i);
        all.push_back(wall_ms() - before);
    }
    return median(all);
}

}  // namespace

int main(int argc, char** argv) {
    const int side = argc > 2 ? std::atoi(argv[2]) : 100;
    const auto text = fmt::format("lattice = \"cubic\"\n[[body]]\nshape = \"box({0}, {0}, {0})\"\n[facts]\nsource = \"id == 0\"\n", side);
    machine_line("wall milliseconds, medians of 5");
    Run world(argv[1], text);
    const sim::Registry registry = sim::Registry::standard();
    timeline::Timeline run([&] { return std::make_unique<sim::Simulation>(world.info(), *world.world, *world.target, *world.comm, 1); },
                           registry, {});
    need(run.start());
    const double forward = median_ms(1, [&](int) { need(run.to(1'000'000)); });
    std::printf("%d catoms, quiet after %lld ticks in %.0f ms; %zu snapshots of %.1f MB in all\n", side * side * side,
                static_cast<long long>(run.tick()), forward, run.history().ticks().size(),
                1e-6 * static_cast<double>(run.history().bytes()));
    timeline::History history(std::size_t{1} << 40);
    const auto save = [&](sim::ShareSink& sink) { return run.simulation().save(run.simulation().counters().view(), sink); };
    const double first = median_ms(1, [&](int) { need(history.keep(0, save, *world.comm)); });
    const double bytes = static_cast<double>(history.bytes());
    const double shared = median_ms(5, [&](int i) { need(history.keep(i + 1, save, *world.comm)); });
    std::printf("  snapshot: the first %.1f ms, %.1f bytes a catom; later ones %.1f ms\n", first, bytes / (1.0 * side * side * side),
                shared);
    const double back = median_ms(5, [&](int) { need(run.back()); });
    std::printf("  one step back: %.1f ms\n", back);
}
