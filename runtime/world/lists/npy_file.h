// Tables of numbers in NumPy's format, as numpy.save() writes them.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "runtime/base/error.h"

namespace meld::world {

// Numbers in rows and columns, a view of the bytes of a file, which must outlive it.
class NpyTable {
  public:
    // Versions 1 to 3; whole numbers of 1 to 8 bytes and numbers of 4 or 8 bytes, in either byte order, by rows or by columns.
    // Errors: it is not such a file, or not a table.
    static Result<NpyTable> read(std::string_view bytes, const std::string& path);
    // Whether bytes begin like such a file.
    static bool is_one(std::string_view bytes) { return bytes.starts_with("\x93NUMPY"); }
    // Errors: what is to be read as text is an archive of NumPy, or has the name of one of its files.
    static Result<void> check_text(std::string_view bytes, std::string_view path);

    std::size_t rows() const { return rows_; }
    std::size_t columns() const { return columns_; }
    // Exact for whole numbers below 2^53.
    double at(std::size_t row, std::size_t column) const;

  private:
    std::string_view data_;
    std::size_t rows_ = 0, columns_ = 0, item_bytes_ = 0;
    char kind_ = 'f';  // 'i', 'u' or 'f'.
    bool by_columns_ = false, big_endian_ = false;
};

}  // namespace meld::world
