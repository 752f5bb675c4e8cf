// Pieces: the tokens and the comments of a file in their order, with what the formatter keeps of the author's layout.
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
    // How many lines end between the piece before and this one.
    std::uint32_t newlines_before = 0;
    // Whether white space or a comment stands before it.
    bool apart = false;
    // Where it starts in its line, from 0, and where the code before a comment ends.
    std::size_t column = 0;
    std::size_t code_end = 0;

    bool comment() const { return kind != Kind::Token; }
    bool is(TokenKind wanted) const { return kind == Kind::Token && token == wanted; }
    bool own_line() const { return newlines_before > 0; }
};

// All pieces of a file whose scan reported no error, without the End.
std::vector<Piece> pieces_of(const source::File& file, const std::vector<syntax::Token>& tokens);

// Columns that a text without tabs takes: its code points.
std::size_t width(std::string_view text);

// Part of a file: a declaration or rule, or a comment on lines of its own.
struct Entry {
    // Empty: a comment alone.
    std::vector<Piece> item = {};
    // Those behind the item in its last line; or those of the line, which are one as a rule.
    std::vector<Piece> comments = {};
    bool blank_before = false;

    bool comment_alone() const { return item.empty(); }
};

// The pieces cut at the end of each declaration or rule.
std::vector<Entry> entries_of(std::vector<Piece> pieces);

}  // namespace meld::format
