// The tokens of a file divided into declarations and rules; works for unfinished ones too.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "compiler/source/source.h"
#include "compiler/syntax/tokens.h"

namespace meld::lsp {

using syntax::Token;
using syntax::TokenKind;

// Tokens [begin, end) of one item, with its full stop if it has one.
struct Item {
    std::size_t begin = 0;
    std::size_t end = 0;
    // A declaration's keyword, or Name for a rule.
    TokenKind kind = TokenKind::Name;
    // The arrow of a rule, or `end`.
    std::size_t arrow = 0;
};

struct FileTokens {
    std::vector<Token> tokens;
    std::vector<std::size_t> partners;  // Of brackets, as syntax::match_brackets.
    std::vector<Item> items;

    // The item that holds the byte: the last that starts at or before it.
    std::optional<std::size_t> item_at(std::size_t offset) const;
};

FileTokens read_items(const source::File& file, std::uint32_t index);

// The text of an item on one line: blanks collapsed, comments removed.
std::string item_text(const source::File& file, const FileTokens& tokens, std::size_t item);

// The author's comment on an item: the comment lines right above it, and the comment after it.
std::string doc_comment(const source::File& file, const FileTokens& tokens, std::size_t item);

}  // namespace meld::lsp
