// Tokens: the output of the scanner and the input of the grammar.
#pragma once

#include <cstdint>
#include <initializer_list>
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
// Whether it is a value by itself: a name, a variable, or a literal number, string or catom.
bool is_atom(TokenKind kind);
// Whether it is a closing bracket.
bool is_closing(TokenKind kind);

struct Token {
    TokenKind kind = TokenKind::End;
    Span span = {};
    bool first_on_line = false;
    // The scanner reported a mistake in it or right before it, so a syntax error here would add nothing.
    bool damaged = false;
    // A name, a variable, a number as written, a text with its escapes resolved, the path of an include, the unit of a delay.
    std::string text = {};
    // Int, Catom, RunArgument. An Int of 2^63 is stored as the smallest int: it is allowed only right after a minus.
    std::int64_t integer = 0;
    // Float, Delay.
    double real = 0;
};

// The number of bytes of the UTF-8 sequence at the start of the text; 0 if there is none (RFC 3629: no overlong forms, no surrogates) and
// for a NUL, which no program may contain.
std::size_t utf8_sequence_size(std::string_view text);

// The end of the valid text: the offset of the first NUL or of the first byte that is not UTF-8; the size if it is all text.
std::size_t text_end(std::string_view text);

// The tokens of the file without comments, ended by one End. Every word is a Name: see classify_words. Reports characters that start no
// token, unterminated comments and strings, and numbers that do not fit. A file that is not text has no tokens and one error.
std::vector<Token> scan(const source::File& file, std::uint32_t file_index, diagnostics::Reporter& report);

// Whether a word is one of these.
bool is_one_of(std::string_view word, std::initializer_list<std::string_view> words);

// Gives words that are keywords in their context their own kind, so that `end` or `data` can be names everywhere else.
void classify_words(std::vector<Token>& tokens);

// Whether this opening bracket is closed by that closing one.
bool closes(TokenKind open, TokenKind close);

// For each opening bracket the index of its closing one, and the reverse; 0 if it has none (token 0 closes nothing).
std::vector<std::size_t> match_brackets(const std::vector<Token>& tokens);

}  // namespace meld::syntax
