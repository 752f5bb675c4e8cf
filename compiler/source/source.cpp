// Files are kept whole in memory; the starts of their lines are found once, so that a place is a binary search.
#include "compiler/source/source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <limits>
#include <system_error>
#include <utility>

#include "runtime/base/assert.h"

namespace meld::source {

namespace {

// A program of this size is a mistake (somebody compiled a recording), and offsets must fit in 32 bits.
constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{64} << 20;

}  // namespace

File::File(std::string path, std::string text) : path_(std::move(path)), text_(std::move(text)) {
    MELD_CHECK(text_.size() < std::numeric_limits<std::uint32_t>::max(), "{} bytes", text_.size());
    line_starts_.push_back(0);
    for (std::size_t i = 0; i < text_.size(); ++i) {
        if (text_[i] == '\n') line_starts_.push_back(static_cast<std::uint32_t>(i + 1));
    }
}

Place File::place(std::uint32_t offset) const {
    const auto after = std::upper_bound(line_starts_.begin(), line_starts_.end(), offset);
    const auto line = static_cast<std::uint32_t>(after - line_starts_.begin());
    return {line, offset - line_starts_[line - 1] + 1};
}

std::string_view File::line(std::uint32_t number) const {
    MELD_EXPECT(number >= 1 && number <= line_count(), "line {}", number);
    const std::size_t begin = line_starts_[number - 1];
    std::size_t end = number < line_count() ? line_starts_[number] - 1 : text_.size();
    if (end > begin && text_[end - 1] == '\r') --end;
    return std::string_view(text_).substr(begin, end - begin);
}

std::uint32_t FileSet::add(std::string path, std::string text) {
    files_.push_back(std::make_unique<File>(std::move(path), std::move(text)));
    return static_cast<std::uint32_t>(files_.size() - 1);
}

Result<std::uint32_t> FileSet::read(const std::string& path) {
    namespace fs = std::filesystem;
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (status.type() == fs::file_type::not_found) return fail(fmt::format("there is no file {}", path));
    if (!fs::exists(status)) return fail(fmt::format("{} cannot be read ({})", path, error.message()));
    if (fs::is_directory(status)) return fail(fmt::format("{} is a folder, not a file", path));
    // Only a regular file knows its size before it is read; a pipe is read up to the limit.
    if (fs::is_regular_file(status) && fs::file_size(path, error) > kMaxFileBytes) {
        return fail(fmt::format("{} is larger than 64 MiB", path), "a program is text; give data to the world instead");
    }
    std::ifstream stream(path, std::ios::binary);
    if (!stream) return fail(fmt::format("{} cannot be read ({})", path, std::generic_category().message(errno)));
    std::string text;
    char buffer[65536];
    while (stream.read(buffer, sizeof buffer) || stream.gcount() > 0) {
        text.append(buffer, static_cast<std::size_t>(stream.gcount()));
        if (text.size() > kMaxFileBytes) return fail(fmt::format("{} is larger than 64 MiB", path));
    }
    if (stream.bad()) return fail(fmt::format("{} cannot be read to its end", path));
    return add(path, std::move(text));
}

std::string_view FileSet::text(Span span) const {
    const std::string& whole = file(span).text();
    const std::size_t begin = std::min<std::size_t>(span.begin, whole.size());
    const std::size_t end = std::clamp<std::size_t>(span.end, begin, whole.size());
    return std::string_view(whole).substr(begin, end - begin);
}

}  // namespace meld::source
