// Source files and spans: the position of a piece of program text.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/base/files/input_file.h"

namespace meld::source {

// A half-open range of bytes [begin, end) of the file with this index in the FileSet.
struct Span {
    std::uint32_t file = 0;
    std::uint32_t begin = 0;
    std::uint32_t end = 0;

    // The smallest span that contains both; they must be in one file.
    Span to(Span other) const { return {file, begin < other.begin ? begin : other.begin, end > other.end ? end : other.end}; }
};

// A place as people count: line and column from 1, column in bytes.
struct Place {
    std::uint32_t line = 1;
    std::uint32_t column = 1;
};

class File {
  public:
    enum class From { Memory, Disk };
    File(std::string path, std::string text, From from = From::Memory);
    bool on_disk() const { return from_ == From::Disk; }
    const std::string& path() const { return path_; }
    const std::string& text() const { return text_; }
    Place place(std::uint32_t offset) const;
    // The text of a line (counted from 1) without its end.
    std::string_view line(std::uint32_t number) const;
    std::uint32_t line_count() const { return static_cast<std::uint32_t>(line_starts_.size()); }

  private:
    std::string path_;
    std::string text_;
    From from_;
    std::vector<std::uint32_t> line_starts_;
};

// All files of one compilation. A file never moves once added.
class FileSet {
  public:
    // Adds text under a name that need not exist on disk; returns its index.
    std::uint32_t add(std::string path, std::string text, File::From from = File::From::Memory);
    // Reads a file of at most 64 MiB; the errors are those of read_input.
    Result<std::uint32_t> read(const std::string& path, InputKind kind = InputKind::File);
    const File& file(std::uint32_t index) const { return *files_[index]; }
    const File& file(Span span) const { return *files_[span.file]; }
    std::string_view text(Span span) const;
    Place begin(Span span) const { return file(span).place(span.begin); }
    Place end(Span span) const { return file(span).place(span.end); }
    std::size_t count() const { return files_.size(); }

  private:
    std::vector<std::unique_ptr<File>> files_;
};

}  // namespace meld::source
