// Shared by the benchmarks that run programs: a compiled program on a world.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>

#include "runtime/comm/transport/communicator.h"
#include "runtime/driver/run/run.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/module/load/module.h"
#include "runtime/sim/simulation.h"
#include "runtime/world/ensemble/target.h"
#include "runtime/world/file/world_file.h"
#include "tests/bench/clock.h"

namespace meld::bench {

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

// A program on a world, in this process.
struct Run {
    std::unique_ptr<world::World> world;
    Module module;
    std::unique_ptr<world::Target> target;
    std::unique_ptr<comm::Communicator> comm = comm::make_single();
    std::unique_ptr<sim::Simulation> simulation;

    // `add`: called before the start, for modules of its own.
    Run(const std::string& program, const std::string& world_text, int threads = 1, const std::function<void(Run&)>& add = {})
        : world(std::make_unique<world::World>(need(world::parse_world(world_text, "benchmark")))),
          module(need(load_module(need(driver::compile_program({.program = program, .by_links = world->by_links})), kAbiVersion))),
          target(std::make_unique<world::Target>(need(world::Target::make(*world, world::Lattice(world->lattice))))) {
        simulation = std::make_unique<sim::Simulation>(info(), *world, *target, *comm, threads);
        if (add) add(*this);
        need(simulation->start(sim::Registry::standard()));
    }
    const ModuleInfo& info() const { return *static_cast<const ModuleInfo*>(module.table()); }
    sim::Subdomain& subdomain() { return simulation->subdomain(); }

    // Runs to quiet; returns CPU seconds.
    double settle() {
        const double before = cpu_now();
        need(simulation->run({.looks = false}, [] {}));
        return cpu_now() - before;
    }
};

}  // namespace meld::bench
