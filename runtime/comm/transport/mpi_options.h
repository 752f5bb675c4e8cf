// Settings of the MPI communicator for tests and measurements; all other code calls make_mpi().
#pragma once

#include <cstddef>
#include <memory>

#include "runtime/comm/transport/communicator.h"

namespace meld::comm {

enum class ExchangeKind {
    Automatic,  // By counts for few processes, by consensus for many.
    Consensus,
    Counts,
};

struct MpiOptions {
    ExchangeKind exchange = ExchangeKind::Automatic;
    std::size_t chunk_bytes = std::size_t{1} << 30;  // MPI counts are int; a gigabyte is well below the limit.
};

std::unique_ptr<Communicator> make_mpi(const MpiOptions& options);

}  // namespace meld::comm
