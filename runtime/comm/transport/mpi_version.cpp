#include "runtime/comm/transport/mpi_version.h"

#include <mpi.h>

#include <array>

namespace meld::comm {

// Open MPI adds a comma and who has packed it, others a line.
std::string mpi_version() {
    std::array<char, MPI_MAX_LIBRARY_VERSION_STRING> text{};
    int size = 0;
    if (MPI_Get_library_version(text.data(), &size) != MPI_SUCCESS) return "";
    const std::string all(text.data());
    return all.substr(0, all.find_first_of(",\n"));
}

}  // namespace meld::comm
