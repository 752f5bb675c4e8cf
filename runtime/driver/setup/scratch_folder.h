// A folder for files that a command needs for itself: it goes when the command ends, also when a signal ends it.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/base/temporary_files.h"

namespace meld::driver {

class Scratch {
  public:
    Scratch() = default;
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;
    ~Scratch();

    // In the folder for temporary files. From now on signals wait until the command handles them: one that ended it before would leave the
    // folder. Errors: it cannot be made.
    Result<void> make(std::string_view name);
    const std::filesystem::path& path() const { return path_; }
    // Writes a file in it, and the folders that lead there.
    Result<void> write(const std::filesystem::path& file, std::string_view text);
    // Somebody else will write such a file in it.
    void expect(const std::filesystem::path& file) { leftovers_.emplace_back(file.string()); }

  private:
    std::filesystem::path path_;
    std::vector<Leftover> leftovers_;  // What is in a folder comes after it.
};

}  // namespace meld::driver
