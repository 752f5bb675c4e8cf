// What a run is made of: the program's module, the world with the changes of the command line, and the components.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "runtime/base/error.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/driver/setup/memory_need.h"
#include "runtime/driver/setup/options.h"
#include "runtime/module/load/module.h"
#include "runtime/sim/simulation.h"
#include "runtime/world/description/world.h"
#include "runtime/world/ensemble/target.h"

namespace meld::driver {

// The path of the world's file; empty if there is none.
std::string world_path(const RunOptions& options);
// The world, with the seed, arguments and constants of the command line.
Result<world::World> choose_world(const RunOptions& options, const ModuleInfo* module = nullptr);

// What a process reads and checks by itself before it communicates with the others.
struct Inputs {
    Module module;
    world::World world;
    world::Target target;
    std::optional<sim::BrickCounts> counts = {};  // From count_catoms() on, until the set-up.
    MemoryNeed memory = {};
    int processes_here = 1;  // That share this machine.
    sim::Registry registry = sim::Registry::standard();

    const ModuleInfo& info() const { return *static_cast<const ModuleInfo*>(module.table()); }
};

Result<Inputs> read_inputs(const RunOptions& options, const comm::Communicator& comm, const std::string& module_path);

// Counts the catoms of processes that have the same inputs, and what memory they need. Collective; all return the same. Errors: the world
// has no catoms, or does not fit. `before_check` is called when the need is known, and before it is compared with what is free.
Result<void> count_catoms(const RunOptions& options, comm::Communicator& comm, Inputs& inputs,
                          const std::function<Result<void>(const MemoryNeed&)>& before_check = {});

}  // namespace meld::driver
