// What every communicator must do, written once: the tests run it over one process, over threads and over MPI processes.
// Each function is called by all processes together and throws in the process that sees a difference.
#pragma once

#include <string>
#include <vector>

#include "runtime/comm/transport/communicator.h"

namespace meld::comm::semantics {

struct Case {
    std::string name;
    void (*run)(Communicator&);
};

// All cases; they may be run one after another over one communicator.
const std::vector<Case>& all_cases();

}  // namespace meld::comm::semantics
