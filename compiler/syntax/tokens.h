// Tokens: what the scanner reads and the grammar is made of.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/diagnostics/diagnostics.h"
#include "compiler/source/source.h"

namespace meld::syntax {

using source::Span;

enum class TokenKind : std::uint8_t {
#define MELD_TOKEN(name, description) name,
#include "compiler/syntax/tokens.def"
#undef MELD_TOKEN
};

// "Name", "LeftParen": for the token dump.
std::string_view kind_name(TokenKind kind);
// "a name", "`(`": for messages.
std::string_view description(TokenKind kind);

// Whether it is the first word of a declaration, once words are classified.
bool starts_declaration(TokenKind kind);
// Whether it is a value by itself: a name, a variable, a literal of a number, a text or a catom.
bool is_atom(TokenKind kind);

struct Token {
    TokenKind kind = TokenKind::End;
    Span span = {};
    bool first_on_line = false;
    // The scanner reported a mistake in it or right before it, so that a syntax error here says nothing new.
    bool damaged = false;
    // A name, a variable, a number as written, a text with its escapes resolved, the path of an include, the unit of a delay.
    std::string text = {};
    // Int, Catom, RunArgument. An Int of 2^63 is stored as the smallest int: it is right behind a minus alone.
    std::int64_t integer = 0;
    // Float, Delay.
    double real = 0;
};

// The number of bytes of the UTF-8 sequence that starts the text; 0 if it starts none (RFC 3629: no overlong forms, no surrogates) and
// for a NUL, which no program holds.
std::size_t utf8_sequence_size(std::string_view text);

// Where the file stops being text: the offset of the first NUL or of the first byte that is no UTF-8; the size if it is all text.
std::size_t text_end(std::string_view text);

// The tokens of the file without comments, ended by one End. Every word is a Name: see classify_words. Reports characters that start
// no token, comments and strings that never end, numbers that do not fit. A file that is no text has no tokens and one error.
std::vector<Token> scan(const source::File& file, std::uint32_t file_index, diagnostics::Reporter& report);

// Gives the words that mean something where they stand their own kind, so that `end` or `data` can be names everywhere else.
void classify_words(std::vector<Token>& tokens);

// Whether this opening bracket is closed by that closing one.
bool closes(TokenKind open, TokenKind close);

// For each opening bracket the index of its closing one, and the other way round; 0 where it has none (token 0 closes nothing).
std::vector<std::size_t> match_brackets(const std::vector<Token>& tokens);

}  // namespace meld::syntax
