// Shared by the benchmarks: CPU time, medians, a compiled program on a world, and the line that says on what machine.
#pragma once

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "runtime/comm/communicator.h"
#include "runtime/driver/run.h"
#include "runtime/module/module.h"
#include "runtime/sim/simulation.h"
#include "runtime/tuple/facts.h"
#include "runtime/world/target.h"

namespace meld::bench {

inline double cpu_now() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

template <class T>
T need(Result<T> result) {
    if (result) return std::move(*result);
    std::fprintf(stderr, "%s\n", result.error().message().c_str());
    std::exit(static_cast<int>(result.error().code));
}
inline void need(Result<void> result) {
    if (result) return;
    std::fprintf(stderr, "%s\n", result.error().message().c_str());
    std::exit(static_cast<int>(result.error().code));
}

inline double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

inline void machine_line() {
    std::ifstream info("/proc/cpuinfo");
    std::string line, model = "unknown processor";
    while (std::getline(info, line))
        if (line.starts_with("model name")) {
            model = line.substr(line.find(':') + 2);
            break;
        }
    std::printf("machine: %s, %u hardware threads; CPU seconds, medians\n", model.c_str(), std::thread::hardware_concurrency());
}

// A program on a world, in this process.
struct Run {
    Module module;
    std::unique_ptr<world::World> world;
    std::unique_ptr<world::Target> target;
    std::unique_ptr<comm::Communicator> comm = comm::make_single();
    std::unique_ptr<sim::Simulation> simulation;

    Run(const std::string& program, const std::string& world_text, int threads = 1)
        : module(need(load_module(need(driver::compile_program(program)), kAbiVersion))),
          world(std::make_unique<world::World>(need(world::parse_world(world_text, "benchmark")))),
          target(std::make_unique<world::Target>(need(world::Target::make(*world, world::Lattice(world->lattice))))) {
        simulation = std::make_unique<sim::Simulation>(info(), *world, *target, *comm, threads);
        need(simulation->start(sim::Registry::standard()));
    }
    const ModuleInfo& info() const { return *static_cast<const ModuleInfo*>(module.table()); }
    sim::PartState& part() { return simulation->part(); }

    // Runs to quiet; returns CPU seconds.
    double settle() {
        const double before = cpu_now();
        need(simulation->run({}, [] {}));
        return cpu_now() - before;
    }
};

}  // namespace meld::bench
