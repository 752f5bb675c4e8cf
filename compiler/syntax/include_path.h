// Which file an include means, and which files have been read already.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "compiler/diagnostics/diagnostics.h"
#include "compiler/source/source.h"

namespace meld::syntax {

class Includes {
  public:
    // library_paths: folders searched after the including file's own; first_file counts as read.
    Includes(std::vector<std::string> library_paths, const std::string& first_file);

    // Finds the file among those of the set, then on disk. Nothing if it was read before, or cannot be (which is reported at `where`).
    // After a file was opened and parsed, close() must follow.
    std::optional<std::uint32_t> open(source::FileSet& files, std::uint32_t from, const std::string& path, source::Span where,
                                      diagnostics::Reporter& report);
    void close() { --depth_; }

  private:
    std::vector<std::string> library_paths_;
    std::set<std::string> read_;
    int depth_ = 0;
};

}  // namespace meld::syntax
