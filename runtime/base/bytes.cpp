#include "runtime/base/bytes.h"

#include <fmt/format.h>

namespace meld {

void ByteReader::end_too_early(std::size_t size) {
    const std::size_t at = size_ - left();
    MELD_CHECK(origin_ == Origin::Outside, "{} has {} bytes, and {} are read at byte {}", what_, size_, size, at);
    if (!failed()) error_ = fmt::format("{} ends too early: it has {} bytes, and {} more are needed at byte {}", what_, size_, size, at);
    at_ = end_;
}

Result<void> ByteReader::outcome() const {
    if (failed()) return fail(error_, "It is damaged or was not written to its end");
    return {};
}

}  // namespace meld
