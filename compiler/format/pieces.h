// Pieces: the tokens and comments of a file in their order, with the parts of the author's layout that the formatter keeps.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/source/source.h"
#include "compiler/syntax/tokens.h"

namespace meld::format {

using syntax::TokenKind;

struct Piece {
    enum class Kind { Token, LineComment, BlockComment } kind = Kind::Token;
    TokenKind token = TokenKind::End;
    // As written, without blanks at the ends of lines.
    std::string text = {};
    // The number of line ends between the previous piece and this one.
    std::uint32_t newlines_before = 0;
    // Whether white space or a comment comes before it.
    bool apart = false;
    // The column in its line where it starts, from 0, and where the code before a comment ends.
    std::size_t column = 0;
    std::size_t code_end = 0;

    bool comment() const { return kind != Kind::Token; }
    bool is(TokenKind wanted) const { return kind == Kind::Token && token == wanted; }
    bool own_line() const { return newlines_before > 0; }
};

// All pieces of a file whose scan reported no error, without the End.
std::vector<Piece> pieces_of(const source::File& file, const std::vector<syntax::Token>& tokens);

// The columns of a text without tabs: its code points.
std::size_t width(std::string_view text);

// Part of a file: a declaration or rule, or comments on separate lines.
struct Entry {
    // Empty: only a comment.
    std::vector<Piece> item = {};
    // The comments after the item on its last line; or those of the line, usually one.
    std::vector<Piece> comments = {};
    bool blank_before = false;

    bool comment_alone() const { return item.empty(); }
};

// The pieces, divided at the end of each declaration or rule.
std::vector<Entry> entries_of(std::vector<Piece> pieces);

}  // namespace meld::format
