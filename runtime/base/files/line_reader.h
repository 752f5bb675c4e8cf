// A file that is read line by line.
#pragma once

#include <cstdint>
#include <fstream>
#include <string>

#include "runtime/base/error.h"

namespace meld {

class LineReader {
  public:
    explicit LineReader(std::string path);
    const std::string& path() const { return path_; }
    // Lines read so far, and where the next one begins.
    std::uint64_t number() const { return number_; }
    std::uint64_t offset() const { return offset_; }
    // Goes on at the line that begins there, after so many.
    void seek(std::uint64_t offset, std::uint64_t number);
    // The next line, without its end; false after the last one, or if it cannot be read.
    bool next(std::string& line);
    // Whether the last line that was read has an end.
    bool ended() const { return !in_.eof(); }
    // That there is no further line is no error; that it cannot be opened or read is.
    Result<void> outcome() const;

  private:
    std::string path_;
    std::ifstream in_;
    std::uint64_t number_ = 0, offset_ = 0;
    int error_ = 0;  // Of the system.
};

}  // namespace meld
