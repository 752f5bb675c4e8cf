#include "runtime/comm/transport/collective_result.h"

#include <string>
#include <utility>
#include <vector>

#include "runtime/base/bytes.h"

namespace meld::comm {

namespace {

std::vector<std::byte> packed(const Result<void>& outcome) {
    ByteWriter out;
    out.write(outcome.has_value());
    if (!outcome) {
        out.write(outcome.error().code);
        out.write_string(outcome.error().problem);
        out.write_string(outcome.error().suggestion);
    }
    return out.take();
}

Result<void> unpacked(const std::vector<std::byte>& bytes) {
    ByteReader in(bytes, "how it went on a process");
    if (in.read<bool>()) return {};
    const auto code = in.read<ExitCode>();
    std::string problem = in.read_string();
    return fail(std::move(problem), in.read_string(), code);
}

}  // namespace

Result<void> outcome_of_first(Communicator& comm, const Result<void>& mine) {
    if (comm.processes() == 1) return mine;
    return unpacked(comm.allgather_any(packed(mine))[0]);
}

Result<void> outcome_of_all(Communicator& comm, const Result<void>& mine) {
    if (comm.processes() == 1) return mine;
    for (const auto& theirs : comm.allgather_any(packed(mine)))
        if (Result<void> outcome = unpacked(theirs); !outcome) return outcome;
    return {};
}

}  // namespace meld::comm
