#include "runtime/results/record/digest_file.h"

#include <fmt/format.h>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/comm/transport/collective_result.h"

namespace meld::record {

// Each line is written as soon as its tick ends.
Result<void> DigestFile::after(sim::Subdomain& subdomain) {
    const Digest digest = running_.of(subdomain);
    if (check_every_ > 0 && subdomain.tick() % check_every_ == 0)
        if (const Result<void> same = running_.check(subdomain); !same) return same;
    Result<void> written;
    if (file_) {
        last_line_ = fmt::format("tick {} {}\n", subdomain.tick(), digest.to_string());
        file_->write(last_line_);
        written = file_->flush();
        if (written && !OutputFile::names_stream(path_) && place_.empty())
            written = file_->place().map([&](std::string place) { place_ = std::move(place); });
    }
    return comm::outcome_of_first(subdomain.comm, written);
}

Result<void> DigestFile::secure(sim::Subdomain& subdomain) {
    return comm::outcome_of_first(subdomain.comm, file_ ? file_->sync() : Result<void>());
}

void DigestFile::save_rest(const sim::Subdomain& subdomain, ByteWriter& out) const {
    if (subdomain.comm.process() != 0) return;
    MELD_EXPECT(file_.has_value());
    out.write_string(place_);
    out.write(file_->size());
    out.write_string(last_line_);
}

Result<void> DigestFile::load_rest(sim::Subdomain& subdomain, ByteReader& in) {
    if (in.done()) return {};
    if (file_) {
        // Of a run that branches off: what was written is the other run's.
        in.read_bytes(in.left());
        return {};
    }
    place_ = in.read_string();
    const auto size = in.read<std::uint64_t>();
    last_line_ = in.read_string();
    if (subdomain.comm.process() != 0) return {};
    Result<OutputFile> file = OutputFile::names_stream(path_) ? OutputFile::open(path_, Appears::AtOnce, durability_)
                                                              : OutputFile::reopen(path_, place_, size, durability_);
    if (!file) return tl::unexpected<Error>(file.error());
    file_.emplace(std::move(*file));
    if (OutputFile::names_stream(path_)) return {};
    const Result<std::string> end = file_->read_end(last_line_.size());
    if (!end) return tl::unexpected<Error>(end.error());
    if (*end != last_line_)
        return fail(fmt::format("cannot go on with {}: its line of tick {} is not the one that was written", path_, subdomain.tick()),
                    "Put it back as the run left it");
    resumes_at_ = size;
    return {};
}

Result<void> DigestFile::resumed(sim::Subdomain& subdomain) {
    Result<void> ready;
    if (resumes_at_) {
        // Only now, when no process has refused to go on, is anything of the file changed.
        file_->replace_from(*resumes_at_, "");
        ready = file_->flush();
    } else if (file_ && place_.empty() && !OutputFile::names_stream(path_)) {
        // A run that branches off keeps a checkpoint before its first tick, which names the file although nothing is in it.
        ready = file_->place().map([&](std::string place) {
            place_ = std::move(place);
            file_->note_written();
        });
    }
    resumes_at_.reset();
    return comm::outcome_of_first(subdomain.comm, ready);
}

void DigestFile::finish(sim::Subdomain& subdomain) {
    Result<void> written;
    if (file_) written = file_->commit();
    ending_ = comm::outcome_of_first(subdomain.comm, written);
}

}  // namespace meld::record
