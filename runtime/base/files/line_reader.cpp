#include "runtime/base/files/line_reader.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace meld {

LineReader::LineReader(std::string path) : path_(std::move(path)), in_(path_, std::ios::binary), error_(in_.is_open() ? 0 : errno) {}

void LineReader::seek(std::uint64_t offset, std::uint64_t number) {
    in_.clear();
    in_.seekg(static_cast<std::streamoff>(offset));
    offset_ = offset;
    number_ = number;
}

bool LineReader::next(std::string& line) {
    errno = 0;
    if (!std::getline(in_, line)) {
        if (in_.bad()) error_ = errno != 0 ? errno : EIO;
        return false;
    }
    offset_ += line.size() + 1;
    ++number_;
    return true;
}

Result<void> LineReader::outcome() const {
    if (error_ == 0) return {};
    return fail(fmt::format("cannot read {}: {}", path_, std::strerror(error_)));
}

}  // namespace meld
