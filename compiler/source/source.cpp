// Files are kept whole in memory; the starts of their lines are found once, so finding a line is a binary search.
#include "compiler/source/source.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "runtime/base/assert.h"

namespace meld::source {

namespace {

// A program of this size is a mistake (somebody compiled a recording), and offsets must fit in 32 bits.
constexpr std::uint64_t kMaxFileBytes = std::uint64_t{64} << 20;

}  // namespace

File::File(std::string path, std::string text, From from) : path_(std::move(path)), text_(std::move(text)), from_(from) {
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

std::uint32_t FileSet::add(std::string path, std::string text, File::From from) {
    files_.push_back(std::make_unique<File>(std::move(path), std::move(text), from));
    return static_cast<std::uint32_t>(files_.size() - 1);
}

Result<std::uint32_t> FileSet::read(const std::string& path, InputKind kind) {
    Result<std::string> text = read_input(path, kMaxFileBytes, kind);
    if (text && path.ends_with(".toml"))
        return fail(fmt::format("{} is a world, not a program", path),
                    fmt::format("Give the program first, as meldsim run PROGRAM.meld --world {}", path));
    if (!text) return tl::unexpected(text.error());
    return add(path, std::move(*text), File::From::Disk);
}

std::string_view FileSet::text(Span span) const {
    const std::string& whole = file(span).text();
    const std::size_t begin = std::min<std::size_t>(span.begin, whole.size());
    const std::size_t end = std::clamp<std::size_t>(span.end, begin, whole.size());
    return std::string_view(whole).substr(begin, end - begin);
}

}  // namespace meld::source
