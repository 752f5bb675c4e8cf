// Divides a running ensemble anew: bricks get other owners, and what catoms hold goes to them as it would in a snapshot, so the run goes on
// as if they had always been there. Only what changes hands is sent, and what others have to know of it.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/sim/core/code_modules.h"
#include "runtime/sim/core/subdomain.h"
#include "runtime/sim/state/saver.h"
#include "runtime/world/partition/partition.h"

namespace meld::sim {

class HandOver {
  public:
    HandOver(Subdomain& subdomain, Modules modules, CodeModules& codes)
        : subdomain_(subdomain), modules_(std::move(modules)), codes_(codes) {}

    // Whether this run can be divided anew: on a lattice where links are those of cells, in the ideal network, and no module minds.
    static bool possible(const Subdomain& subdomain, const Modules& modules);

    // At the beginning of a tick, when its timers are due and before anything acts; every process calls it with the same partition. Returns
    // how many catoms of this process have gone to others. Cost: a look at each brick at a border, before or after, and what is sent.
    std::uint64_t run(const partition::Partition& next);

  private:
    // What changes, at this process: whom each process gets, itself too, and who is not here any more, or as another.
    struct Plan {
        std::vector<std::vector<Catom>> to;   // By process.
        std::vector<Catom> leave, taken_out;  // The first of them are owned here and go; all of them are taken out.
        std::vector<int> owner;               // By catom: of those that leave, the next; -1: of all others.
    };
    Plan plan(const partition::Halo& then, const partition::Partition& next) const;
    void pack(const Plan& plan, int process, ByteWriter& out) const;
    void take_out(const Plan& plan);
    void take_in(std::span<const comm::Packet> packets);

    Subdomain& subdomain_;
    const Modules modules_;
    CodeModules& codes_;
};

}  // namespace meld::sim
