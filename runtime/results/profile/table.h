// Columns of numbers, and at the end of each line a text.
#pragma once

#include <string>
#include <vector>

namespace meld::profile {

class Table {
  public:
    explicit Table(std::vector<std::string> heads) : rows_{std::move(heads)} {}
    // As many cells as there are heads.
    void add(std::vector<std::string> cells);
    bool empty() const { return rows_.size() == 1; }
    std::size_t size() const { return rows_.size() - 1; }
    // Numbers are aligned at the right; the last column is text, and is not.
    std::string text() const;

  private:
    std::vector<std::vector<std::string>> rows_;
};

}  // namespace meld::profile
