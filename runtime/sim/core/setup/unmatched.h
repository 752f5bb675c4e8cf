// One rule for all that a world says about its catoms and links: what matches nothing is a warning, since it is probably a mistake.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "runtime/comm/transport/communicator.h"

namespace meld::sim {

class Unmatched {
  public:
    explicit Unmatched(comm::Communicator& comm) : comm_(comm) {}
    // One thing that the world says, whether this process has something that it matches, and the warning if no process has. All processes
    // add the same things in the same order.
    void add(bool matches_here, std::function<std::string()> warning);
    // Warns, on process 0. Every process calls it. Cost: an exchange of a bit for each thing, if there are any.
    void warn();

  private:
    comm::Communicator& comm_;
    std::vector<bool> matched_;
    std::vector<std::function<std::string()>> warnings_;
};

}  // namespace meld::sim
