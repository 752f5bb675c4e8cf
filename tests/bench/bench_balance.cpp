// Load balance: a storm, in which alone anything happens, wanders through a cube. How uneven the work is for so many processes, divided
// once and anew, from the work of bricks in a run of one process; for 2 and 4 beside runs on as many, which must agree.
// Usage: bench_balance STORM.meld [SIDE] [STEPS OF THE STORM] [TICKS OF A STEP]
#include <algorithm>
#include <map>
#include <numeric>

#include "runtime/world/file/world_file.h"
#include "tests/bench/measure.h"

namespace {

using namespace meld;
using namespace meld::bench;
using partition::BalanceRule;
using partition::BrickWork;
using partition::Partition;

struct Storm {
    int side, steps, ticks;
    int first = 1;  // Tick

    // A cube whose side is a third of the ensemble's; it goes along the diagonal.
    std::string place(int step) const {
        const int width = side / 3, low = -side / 2 + (side - width) * step / std::max(1, steps - 1);
        return fmt::format("x >= {0} && x < {1} && y >= {0} && y < {1} && z >= {0} && z < {1}", low, low + width);
    }
    std::string world() const {
        std::string text = fmt::format("lattice = \"cubic\"\n[[body]]\nshape = \"box({0}, {0}, {0})\"\n", side);
        for (int step = 0; step < steps; ++step) {
            text += fmt::format("[[event]]\ntick = {}\n", first + step * ticks);
            if (step > 0) text += fmt::format("take.storm = \"{}\"\n", place(step - 1));
            text += fmt::format("give.storm = \"{}\"\n", place(step));
        }
        return text;
    }
    std::int64_t last_tick() const { return std::int64_t{steps} * ticks; }
};

// The work of the bricks of a run, window by window.
using Window = std::map<world::BrickKey, std::uint64_t>;
struct Trace {
    std::vector<Window> windows;
    std::map<world::BrickKey, std::uint64_t> catoms;
    double seconds = 0;
};

Trace trace_of(const std::string& program, const Storm& storm) {
    Run run(program, storm.world());
    sim::Subdomain& s = run.subdomain();
    Trace trace;
    for (sim::Catom c = 0; c < s.ensemble.index_count(); ++c) ++trace.catoms[s.ensemble.key_of(c) >> kBrickCellBits];
    Window window;
    std::vector<std::uint64_t> by_slot;
    const double before = cpu_now();
    need(run.simulation->run({storm.last_tick()}, [&] {
        by_slot.resize(s.ensemble.brick_count() + 1);
        s.each_evaluated([&](u32 c, u64) { ++by_slot[s.geometry().catom_site[c] >> kBrickCellBits]; });
        if (s.tick() % BalanceRule::kWindow != 0) return;
        for (world::Slot slot = 1; slot < by_slot.size(); ++slot)
            if (by_slot[slot] > 0) window[s.lattice.brick_key(s.ensemble.brick(slot))] = std::exchange(by_slot[slot], 0);
        trace.windows.push_back(std::exchange(window, {}));
    }));
    trace.seconds = cpu_now() - before;
    return trace;
}

struct Modelled {
    double once = 1, anew = 1;  // The time of the busiest process over that of all on average, dividing included.
    std::size_t divisions = 0;
    double moved = 0;  // Times the ensemble.
};

Modelled model(const Trace& trace, int processes) {
    std::vector<std::pair<world::BrickKey, std::uint32_t>> counts;
    std::uint64_t all = 0, total = 0;
    for (const auto& [key, count] : trace.catoms) counts.emplace_back(key, static_cast<std::uint32_t>(count)), all += count;
    const Partition first(counts, processes);
    Partition now = first;
    BalanceRule rule(false);
    std::uint64_t once = 0, anew = 0, moved = 0;
    const auto per_process = [&](const Window& window, const Partition& partition) {
        std::vector<std::uint64_t> work(static_cast<std::size_t>(processes));
        for (const auto& [key, w] : window) work[static_cast<std::size_t>(partition.owner(key))] += w;
        return work;
    };
    std::int64_t tick = 0;
    for (const Window& window : trace.windows) {
        tick += BalanceRule::kWindow;
        once += std::ranges::max(per_process(window, first));
        const std::vector<std::uint64_t> work = per_process(window, now);
        anew += std::ranges::max(work);
        total += std::accumulate(work.begin(), work.end(), std::uint64_t{0});
        rule.end_window(work);
        if (!rule.looks()) continue;
        std::vector<BrickWork> bricks;
        for (const auto& [key, count] : trace.catoms) {
            const auto found = window.find(key);
            bricks.push_back({key, found == window.end() ? 0 : found->second, count});
        }
        const std::optional<Partition> next = rule.divide(bricks, now, tick);
        if (!next) continue;
        anew += BalanceRule::kCostOfMove * BalanceRule::most_moved(bricks, now, *next);
        moved += rule.divisions().back().moved;
        now = *next;
    }
    const double mean = static_cast<double>(total) / processes;
    return {static_cast<double>(once) / mean, static_cast<double>(anew) / mean, rule.divisions().size(),
            static_cast<double>(moved) / static_cast<double>(all)};
}

// Divisions of a run on so many processes, which are threads here.
std::vector<partition::Division> divisions_of_run(const std::string& program, const Storm& storm, int processes) {
    const Run compiled(program, "lattice = \"cubic\"\n[[body]]\nshape = \"box(1, 1, 1)\"\n");
    const world::World world = need(world::parse_world(storm.world(), "benchmark"));
    const world::Target target = need(world::Target::make(world, world::Lattice(world.lattice)));
    std::vector<partition::Division> divisions;
    comm::run_threads_as_processes(processes, [&](comm::Communicator& comm) {
        sim::Simulation simulation(compiled.info(), world, target, comm, 1);
        need(simulation.start(sim::Registry::standard()));
        simulation.keep_balance(0);
        need(simulation.run({storm.last_tick()}, [] {}));
        if (comm.process() == 0) divisions = simulation.summary().divisions;
    });
    return divisions;
}

// CPU nanoseconds that a catom takes which goes to another process of two and back, both ends together.
double cost_of_move(const std::string& program, const Storm& storm) {
    const Run compiled(program, "lattice = \"cubic\"\n[[body]]\nshape = \"box(1, 1, 1)\"\n");
    const world::World world = need(world::parse_world(storm.world(), "benchmark"));
    const world::Target target = need(world::Target::make(world, world::Lattice(world.lattice)));
    constexpr int kTimes = 8;
    double seconds = 0;
    std::uint64_t moved = 0;
    comm::run_threads_as_processes(2, [&](comm::Communicator& comm) {
        sim::Simulation simulation(compiled.info(), world, target, comm, 1);
        need(simulation.start(sim::Registry::standard()));
        // Before the storm, all are quiet after two ticks.
        for (int tick = 0; tick < kTimes + 2; ++tick) {
            if (tick >= 2) {
                std::vector<std::pair<world::BrickKey, std::uint32_t>> all;
                const int half = storm.side / 16;
                for (int z = -half; z < half; ++z)
                    for (int y = -half; y < half; ++y)
                        for (int x = -half; x < half; ++x)
                            all.emplace_back(simulation.subdomain().lattice.brick_key({x, y, z}), kBrickCells);
                std::sort(all.begin(), all.end());
                // Two thirds are the first's, or the second's.
                for (std::size_t i = 0; i < all.size(); ++i) all[i].second = (i < all.size() / 2) == (tick % 2 == 0) ? 256 : 512;
                simulation.divide_anew(Partition(all, 2));
            }
            if (tick == 3) comm.barrier();
            const double before = cpu_now();
            const std::size_t owned = simulation.subdomain().ensemble.owned_count();
            need(simulation.step({}));
            comm.barrier();
            if (tick < 3 || comm.process() != 0) continue;
            seconds += cpu_now() - before;
            const std::size_t now = simulation.subdomain().ensemble.owned_count();
            moved += now > owned ? now - owned : owned - now;
        }
    });
    return seconds / static_cast<double>(moved) * 1e9;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: bench_balance STORM.meld [SIDE] [STEPS OF THE STORM] [TICKS OF A STEP]\n");
        return 2;
    }
    machine_line();
    const Storm storm{.side = argc > 2 ? std::atoi(argv[2]) : 64,
                      .steps = argc > 3 ? std::atoi(argv[3]) : 8,
                      .ticks = argc > 4 ? std::atoi(argv[4]) : 160,
                      .first = 1};
    const Trace trace = trace_of(argv[1], storm);
    std::printf("%d^3 catoms, %zu bricks, a storm in %d places for %d ticks each: %.2f s CPU on one process\n", storm.side,
                trace.catoms.size(), storm.steps, storm.ticks, trace.seconds);
    std::uint64_t evaluations = 0;
    for (const Window& window : trace.windows)
        for (const auto& [key, work] : window) evaluations += work;
    std::printf("an evaluation takes %.0f ns, a catom that changes its process %.0f ns\n",
                trace.seconds * 1e9 / static_cast<double>(evaluations), cost_of_move(argv[1], {storm.side, 1, 1, 1000}));
    for (const int processes : {2, 4, 64, 1024}) {
        const Modelled m = model(trace, processes);
        std::printf("%4d processes: divided once %.2f times the mean, anew %.2f (%zu times, %.2f of all catoms moved); gain %.2f\n",
                    processes, m.once, m.anew, m.divisions, m.moved, m.once / m.anew);
        if (processes > 4) continue;
        const auto divisions = divisions_of_run(argv[1], storm, processes);
        std::uint64_t moved = 0;
        for (const partition::Division& each : divisions) moved += each.moved;
        const double part = static_cast<double>(moved) / (static_cast<double>(storm.side) * storm.side * storm.side);
        std::printf("                in a run: %zu times, %.2f of all catoms moved\n", divisions.size(), part);
        if (divisions.size() != m.divisions || part != m.moved) return 1;
    }
    return 0;
}
