#include "runtime/comm/outcome.h"

#include <string>
#include <utility>

#include "runtime/base/bytes.h"

namespace meld::comm {

Result<void> outcome_of_first(Communicator& comm, const Result<void>& mine) {
    if (comm.processes() == 1) return mine;
    ByteWriter out;
    out.write(mine.has_value());
    if (!mine) {
        out.write(mine.error().code);
        out.write_string(mine.error().problem);
        out.write_string(mine.error().suggestion);
    }
    const auto all = comm.allgather_any(out.view());
    ByteReader in(all[0], "how it went on process 0");
    if (in.read<bool>()) return {};
    const auto code = in.read<ExitCode>();
    std::string problem = in.read_string();
    return fail(std::move(problem), in.read_string(), code);
}

}  // namespace meld::comm
