// Lines that were typed in earlier sessions: a text file of this user alone.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace meld::debug {

// The file of this user's sessions, under XDG_STATE_HOME or else ~/.local/state; empty if neither is known.
std::string history_path();

// What cannot be read or written is no error: then nothing is kept.
class LineHistory {
  public:
    // An empty path is no file.
    explicit LineHistory(std::string path) : path_(std::move(path)) {}

    // The last lines, from the oldest on. A file that has become long is shortened to them.
    std::vector<std::string> load() const;
    // Adds a line, after those that other sessions have added meanwhile. The file is made, with its folders, if it is not there.
    void add(std::string_view line) const;

  private:
    std::string path_;
};

}  // namespace meld::debug
