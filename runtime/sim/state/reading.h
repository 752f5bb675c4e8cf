// Reading the blocks of a snapshot, which may come from a file.
#pragma once

#include <fmt/format.h>

#include <string>

#include "runtime/base/bytes.h"
#include "runtime/base/error.h"
#include "runtime/sim/core/damaged_snapshot.h"
#include "runtime/sim/state/share.h"

namespace meld::sim {

inline ByteReader reader(BlockView block, const char* what) { return {block, what, ByteReader::Origin::Outside}; }

// All was read, and no more than there was.
inline Result<void> read_to_its_end(const ByteReader& in, const char* what) {
    if (in.failed()) return tl::unexpected<Error>(in.outcome().error());
    if (!in.done()) return damaged(fmt::format("has {} bytes too many in {}", in.left(), what));
    return {};
}

}  // namespace meld::sim
