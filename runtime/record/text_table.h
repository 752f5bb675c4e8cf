// The distinct texts of a recorded array, of which the array itself holds numbers. Private to runtime/record.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "runtime/record/hdf5_file.h"

namespace meld::record {

// In the file: GROUP/text, the bytes of all texts one after another, and GROUP/ends, where each ends.
class TextTable {
  public:
    // The numbers of these texts, from 0; −1 for the empty one, which stands for none. Texts that are new wait for write().
    std::vector<std::int64_t> numbers(std::span<const std::string> texts);
    // What write() will add to the file at most.
    std::uint64_t waiting_bytes() const;
    // Puts the waiting texts into the file, making the columns when first asked.
    void write(Hdf5File& file, const std::string& group);
    // Forgets the waiting ones: the step that needed them is left out.
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
