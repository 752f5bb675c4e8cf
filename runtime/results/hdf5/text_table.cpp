#include "runtime/results/hdf5/text_table.h"

#include <utility>

#include "runtime/base/assert.h"

namespace meld::record {

namespace {

// Not compressed, so that adding to a chunk does not move its present data.
constexpr std::uint64_t kTextChunk = 16384;  // Bytes
constexpr std::uint64_t kEndsChunk = 1024;
constexpr std::uint64_t kChunkTableBytes = 4096;  // The space that HDF5 needs in a step to find a table's chunks.

}  // namespace

TextTable::TextTable(Hdf5File& file, ByteReader& saved) {
    if (!saved.read<bool>()) return;
    columns_ = saved.read<Columns>();
    std::string all(file.rows(columns_->text), '\0');
    std::vector<std::int64_t> ends(file.rows(columns_->ends));
    file.read_rows(columns_->text, 0, all.size(), all.data());
    file.read_rows(columns_->ends, 0, ends.size(), ends.data());
    for (const std::int64_t end : ends) {
        if (end < bytes_ || static_cast<std::size_t>(end) > all.size()) {
            file.refuse("its strings are not those that were written");
            return;
        }
        const auto begin = static_cast<std::size_t>(std::exchange(bytes_, end));
        numbers_.emplace(all.substr(begin, static_cast<std::size_t>(end) - begin), static_cast<std::int64_t>(numbers_.size()));
    }
}

void TextTable::save(ByteWriter& out) const {
    MELD_EXPECT(waiting_.empty(), "{} strings wait", waiting_.size());
    out.write(columns_.has_value());
    if (columns_) out.write(*columns_);
}

std::vector<std::int64_t> TextTable::numbers(std::span<const std::string> texts) {
    std::vector<std::int64_t> result;
    result.reserve(texts.size());
    for (const std::string& text : texts) {
        if (text.empty()) {
            result.push_back(-1);
            continue;
        }
        const auto [place, is_new] = numbers_.try_emplace(text, static_cast<std::int64_t>(numbers_.size()));
        if (is_new) waiting_.push_back(text);
        result.push_back(place->second);
    }
    return result;
}

std::uint64_t TextTable::waiting_bytes() const {
    std::uint64_t bytes = kTextChunk + kEndsChunk * sizeof(std::int64_t) + kChunkTableBytes;
    for (const std::string& text : waiting_) bytes += text.size() + sizeof(std::int64_t) + 1;
    return bytes;
}

void TextTable::write(Hdf5File& file, const std::string& group) {
    if (!columns_) {
        file.make_group(group);
        columns_ = {file.make_column(group + "/text",
                                     {.type = ElementType::UInt8, .components = 1, .chunk_rows = kTextChunk, .readable_at_once = true}),
                    file.make_column(group + "/ends",
                                     {.type = ElementType::Int64, .components = 1, .chunk_rows = kEndsChunk, .readable_at_once = true})};
    }
    if (waiting_.empty()) return;
    std::string all;
    std::vector<std::int64_t> ends;
    for (const std::string& text : waiting_) {
        all += text;
        ends.push_back(bytes_ + static_cast<std::int64_t>(all.size()));
    }
    file.write_rows(columns_->text, static_cast<std::uint64_t>(bytes_), all.size(), all.data());
    file.write_rows(columns_->ends, file.rows(columns_->ends), ends.size(), ends.data());
    bytes_ += static_cast<std::int64_t>(all.size());
    waiting_.clear();
}

void TextTable::forget() {
    for (const std::string& text : waiting_) numbers_.erase(text);
    waiting_.clear();
}

}  // namespace meld::record
