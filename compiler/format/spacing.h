// What stands between two pieces that share a line, and where a line may end.
#pragma once

#include <vector>

#include "compiler/format/pieces.h"

namespace meld::format {

// What is known of the place before a piece of an item.
struct Gap {
    bool blank = false;      // A blank stands there where the line goes on.
    bool may_break = false;  // The line may end there.
    int depth = 0;           // How many brackets, conditions and lets are open.
};

// The gaps before each piece of an item.
std::vector<Gap> gaps_of(const std::vector<Piece>& item);

bool opens_bracket(const Piece& piece);
bool closes_bracket(const Piece& piece);

}  // namespace meld::format
