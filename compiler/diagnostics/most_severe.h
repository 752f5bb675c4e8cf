// Which diagnostics are shown if there are too many to read.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "compiler/diagnostics/diagnostics.h"

namespace meld::diagnostics {

// The most severe of them, at most `most`, in their original order.
std::vector<Diagnostic> most_severe(const std::vector<Diagnostic>& diagnostics, std::size_t most);

// How many there are of each severity.
class Counts {
  public:
    void add(const std::vector<Diagnostic>& diagnostics);
    // "3 errors, 1 warning and 2 notes"; empty for none.
    std::string in_words() const;

  private:
    std::array<std::size_t, 3> of_{};  // By Severity.
};
std::string count_in_words(const std::vector<Diagnostic>& diagnostics);

}  // namespace meld::diagnostics
