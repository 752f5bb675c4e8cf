// The distinct strings of a recorded array; the array itself holds their indices. Private to runtime/results.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "runtime/results/hdf5/hdf5_file.h"

namespace meld::record {

// In the file: GROUP/text, the bytes of all strings concatenated, and GROUP/ends, the end of each.
class TextTable {
  public:
    TextTable() = default;
    // Of a file that is opened again, in the state that save() wrote: the strings are read from it.
    TextTable(Hdf5File& file, ByteReader& saved);
    void save(ByteWriter& out) const;

    // The indices of these strings, from 0; −1 for the empty string, which means none. New strings wait for write().
    std::vector<std::int64_t> numbers(std::span<const std::string> texts);
    // How many bytes write() will add to the file at most.
    std::uint64_t waiting_bytes() const;
    // Writes the waiting strings to the file; makes the columns on the first call.
    void write(Hdf5File& file, const std::string& group);
    // Drops the waiting strings: the step that needed them is left out.
    void forget();

  private:
    struct Columns {
        ColumnIndex text, ends;
    };
    std::unordered_map<std::string, std::int64_t> numbers_;
    std::vector<std::string> waiting_;
    std::optional<Columns> columns_;
    std::int64_t bytes_ = 0;
};

}  // namespace meld::record
