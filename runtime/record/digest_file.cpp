#include "runtime/record/digest_file.h"

#include <fmt/format.h>

#include "runtime/comm/outcome.h"
#include "runtime/record/state_digest.h"

namespace meld::record {

// Each line is written as soon as its tick ends.
Result<void> DigestFile::after(sim::Subdomain& part) {
    const Digest digest = state_digest(part);
    Result<void> written;
    if (file_) {
        file_->write(fmt::format("tick {} {}\n", part.tick(), digest.to_string()));
        written = file_->flush();
    }
    return comm::outcome_of_first(part.comm, written);
}

void DigestFile::finish(sim::Subdomain& part) {
    Result<void> written;
    if (file_) written = file_->commit();
    ending_ = comm::outcome_of_first(part.comm, written);
}

}  // namespace meld::record
