// Rows of two recordings side by side, some thousand in memory at a time. Private to runtime/results/compare.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "runtime/results/record/recording_reader.h"

namespace meld::compare {

inline constexpr std::uint64_t kRowsAtOnce = 1 << 16;

// The numbers that strings of one recording have in another, so that those can be compared instead of strings.
class Renumbering {
  public:
    Renumbering() = default;
    // From the numbers of `from` to those of `to`; strings that `to` lacks get numbers of their own.
    Renumbering(const std::vector<std::string>& from, const std::vector<std::string>& to) {
        std::unordered_map<std::string_view, std::int64_t> known;
        for (const std::string& text : to) known.emplace(text, static_cast<std::int64_t>(known.size()));
        for (const std::string& text : from) numbers_.push_back(known.emplace(text, static_cast<std::int64_t>(known.size())).first->second);
    }
    void apply(std::vector<std::byte>& words) const {
        if (numbers_.empty()) return;
        for (std::size_t at = 0; at + sizeof(std::int64_t) <= words.size(); at += sizeof(std::int64_t)) {
            std::int64_t number = 0;
            std::memcpy(&number, words.data() + at, sizeof number);
            if (number < 0 || static_cast<std::size_t>(number) >= numbers_.size()) continue;
            std::memcpy(words.data() + at, &numbers_[static_cast<std::size_t>(number)], sizeof number);
        }
    }

  private:
    std::vector<std::int64_t> numbers_;
};

// The rows that one step has in a series, read in order.
class RowWindow {
  public:
    RowWindow(record::RecordingReader& reader, record::SeriesIndex series, record::Rows rows, const Renumbering* renumbering)
        : reader_(&reader), series_(series), rows_(rows), renumbering_(renumbering), row_bytes_(reader.series()[series].row_bytes()) {}

    std::uint64_t count() const { return rows_.count; }
    std::size_t row_bytes() const { return row_bytes_; }
    // Reads the rows from this one on; the pointer is valid until the next call. Errors: those of the reader.
    Result<const std::byte*> at(std::uint64_t row) {
        if (row < first_ || row >= first_ + here_) {
            first_ = row;
            here_ = std::min(kRowsAtOnce, rows_.count - row);
            bytes_.resize(here_ * row_bytes_);
            if (auto done = reader_->read(series_, rows_, first_, here_, bytes_.data()); !done) return tl::unexpected(done.error());
            if (renumbering_ != nullptr) renumbering_->apply(bytes_);
        }
        return bytes_.data() + (row - first_) * row_bytes_;
    }
    // How many rows follow this one in memory, itself included.
    std::uint64_t run(std::uint64_t row) const { return first_ + here_ - row; }

  private:
    record::RecordingReader* reader_;
    record::SeriesIndex series_;
    record::Rows rows_;
    const Renumbering* renumbering_;
    std::size_t row_bytes_;
    std::uint64_t first_ = 0, here_ = 0;
    std::vector<std::byte> bytes_;
};

// Whether two windows with rows of one size have the same bytes.
inline Result<bool> alike(RowWindow a, RowWindow b) {
    if (a.count() != b.count() || a.row_bytes() != b.row_bytes()) return false;
    for (std::uint64_t row = 0; row < a.count();) {
        const Result<const std::byte*> x = a.at(row), y = b.at(row);
        for (const auto* each : {&x, &y})
            if (!*each) return tl::unexpected(each->error());
        const std::uint64_t rows = std::min(a.run(row), b.run(row));
        if (std::memcmp(*x, *y, rows * a.row_bytes()) != 0) return false;
        row += rows;
    }
    return true;
}

}  // namespace meld::compare
