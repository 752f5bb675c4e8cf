// Positions in text as editors count them: lines from 0, columns in UTF-16 code units.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "compiler/source/source.h"

namespace meld::lsp {

using source::Span;

struct Position {
    int line = 0;
    int character = 0;
};

struct Range {
    Position start = {};
    Position end = {};
};

Position position_of(const source::File& file, std::uint32_t offset);
Range range_of(const source::FileSet& files, Span span);

// The byte at a position. A column after the line's end means its end, a line after the text the text's end, and the middle of a character
// its start.
std::size_t offset_of(std::string_view text, Position position);

// Replaces a range of the text, or all of it.
void apply_change(std::string& text, std::optional<Range> range, std::string_view replacement);

}  // namespace meld::lsp
