// The space between two pieces on one line, and where a line may end.
#pragma once

#include <vector>

#include "compiler/format/pieces.h"

namespace meld::format {

// The gap before a piece of an item.
struct Gap {
    bool blank = false;      // There is a blank if the line continues.
    bool may_break = false;  // The line may end there.
    int depth = 0;           // The number of open brackets, conditions and lets.
};

// The gaps before each piece of an item.
std::vector<Gap> gaps_of(const std::vector<Piece>& item);

bool opens_bracket(const Piece& piece);
bool closes_bracket(const Piece& piece);

}  // namespace meld::format
