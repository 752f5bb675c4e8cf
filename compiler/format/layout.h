// One declaration or rule as lines: where it is broken, and how far its lines are indented.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "compiler/format/pieces.h"
#include "compiler/format/spacing.h"

namespace meld::format {

// A line to write. A comment after its code is stored separately, because it may be aligned with those of other lines.
struct Line {
    bool blank_before = false;
    // With its indentation; empty for a comment alone that continues the one after the line above.
    std::string code = {};
    std::optional<Piece> comment = {};
};

class Layout {
  public:
    // Keeps the author's line breaks, and adds some where a line would be too long.
    explicit Layout(const std::vector<Piece>& item);

    // For a view whose head and arrow are on its first line, with more after them: the columns of its head, and of its widest line.
    struct View {
        std::size_t head;
        std::size_t widest_line;
    };
    std::optional<View> view() const;
    // The lines, with this many more blanks before the arrow.
    std::vector<Line> lines(std::size_t padding = 0) const;

  private:
    struct Render;
    void break_at_arrow();
    void break_long_lines();

    const std::vector<Piece>& item_;
    std::vector<Gap> gaps_;
    // Whether a line starts at this piece.
    std::vector<bool> breaks_;
    // The arrow's index, or the number of pieces.
    std::size_t arrow_;
};

}  // namespace meld::format
