// Where labels stand beside a picture, each with a line to what it is about: in two columns, without overlaps, and so that lines of one
// column do not cross.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace meld::render {

// In pixels, from the upper left corner.
struct Anchor {
    double x = 0, y = 0;
};

// The two columns: where their lines begin, the heights of the highest and the lowest label, and from one label to the next.
struct Columns {
    double left = 0, right = 0, top = 0, bottom = 0, step = 1;
    std::size_t capacity() const { return bottom < top ? 0 : 1 + static_cast<std::size_t>((bottom - top) / step); }  // Of one of them.
};

struct Label {
    bool right = false;  // In the right column.
    double y = 0;
};

// For each anchor its label. There must not be more than both columns have room for. Each stands in the nearer column if there is room, and
// as near to the height of its anchor as the others allow. Cost: the square of their number.
std::vector<Label> place_labels(std::span<const Anchor> anchors, const Columns& columns);

}  // namespace meld::render
