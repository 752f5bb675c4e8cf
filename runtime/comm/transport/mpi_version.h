// Which MPI library runs.
#pragma once

#include <string>

namespace meld::comm {

// "Open MPI v4.1.4", as the library says it. Also before it is initialised.
std::string mpi_version();

}  // namespace meld::comm
