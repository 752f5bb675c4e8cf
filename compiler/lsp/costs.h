// What the rules of a program cost in a run, shown beside them: from a profile that `meldsim run --profile` has written.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "compiler/lsp/analysis.h"
#include "runtime/results/profile/file/profile_file.h"

namespace meld::lsp {

// What one rule did, or the rules that it was taken apart into: one for each of its heads.
struct Cost {
    bool counted = false;  // If not, only the time is known.
    std::uint64_t evaluations = 0, firings = 0, derivations = 0, messages = 0, bits = 0;
    double cpu_seconds = 0;
};

// Costs behind the full stops of rules.
struct CostHint {
    Position position;
    std::string label;
    std::string markdown;
};

class Costs {
  public:
    // Errors: the file cannot be read, or is no whole profile of this version.
    static Result<Costs> read(const std::string& path);

    // Whether the file has been written anew since, and can be read.
    bool outdated() const;
    const std::string& path() const { return path_; }

    // The costs of those rules in a range of the program's own file that are as they were in the run, wherever they have moved to.
    // Two rules of one text have the costs of both.
    std::vector<CostHint> hints(const Analysis& analysis, Range range) const;

  private:
    std::string path_;
    std::filesystem::file_time_type written_;
    double seconds_ = 0;
    // By the name of their file without folders, and their text on one line.
    std::map<std::pair<std::string, std::string>, Cost> rules_;
};

}  // namespace meld::lsp
