// The depth of an expression is bounded by its operators plus the depth of the deepest bracket in it; that needs no tree.
#include "compiler/syntax/nesting.h"

#include <algorithm>
#include <string_view>

#include "runtime/base/assert.h"

namespace meld::syntax {

namespace {

// The tokens between two commas at one level of brackets.
struct Segment {
    std::size_t operators = 0;
    std::size_t deepest_bracket = 0;
    // The depth of the segments before it at this level.
    std::size_t deepest_sibling = 0;
    // Operators of the segments around this one.
    std::size_t above = 0;

    std::size_t depth() const { return std::max(operators + deepest_bracket, deepest_sibling); }
};

bool is_separator(TokenKind kind) {
    switch (kind) {
        case TokenKind::Comma:
        case TokenKind::Bar:
        case TokenKind::Semicolon:
        case TokenKind::ViewArrow:
        case TokenKind::LinearArrow:
        case TokenKind::ResultArrow:
            return true;
        default:
            return false;
    }
}

bool is_opening(TokenKind kind) {
    switch (kind) {
        case TokenKind::LeftParen:
        case TokenKind::StructOpen:
        case TokenKind::LeftBracket:
        case TokenKind::NeighbourOpen:
        case TokenKind::LeftBrace:
            return true;
        default:
            return false;
    }
}

// A token that makes its expression one level deeper.
bool is_operator(const Token& token) {
    switch (token.kind) {
        case TokenKind::Cons:
        case TokenKind::Equal:
        case TokenKind::NotEqual:
        case TokenKind::Less:
        case TokenKind::LessEqual:
        case TokenKind::Greater:
        case TokenKind::GreaterEqual:
        case TokenKind::And:
        case TokenKind::Or:
        case TokenKind::Tilde:
        case TokenKind::Plus:
        case TokenKind::Minus:
        case TokenKind::Star:
        case TokenKind::Slash:
        case TokenKind::Percent:
        case TokenKind::Caret:
        case TokenKind::Append:
        case TokenKind::If:
        case TokenKind::Let:
            return true;
        case TokenKind::Name:
            return token.text == "list" || token.text == "set" || token.text == "array";
        default:
            return false;
    }
}

}  // namespace

std::optional<std::size_t> too_deep(const std::vector<Token>& tokens, std::size_t begin, std::size_t end, std::size_t limit) {
    MELD_EXPECT(begin <= end && end <= tokens.size(), "tokens {} to {} of {}", begin, end, tokens.size());
    std::vector<Segment> open(1);
    // An if or let contains its separators: its heads are separated by commas, but they all belong to it.
    std::size_t unclosed_words = 0;
    for (std::size_t i = begin; i < end; ++i) {
        const Token& token = tokens[i];
        Segment& here = open.back();
        if (is_opening(token.kind)) {
            open.push_back({0, 0, 0, here.above + here.operators});
        } else if (is_closing(token.kind) && open.size() > 1) {
            const std::size_t depth = here.depth() + 1;
            open.pop_back();
            open.back().deepest_bracket = std::max(open.back().deepest_bracket, depth);
        } else if (is_separator(token.kind)) {
            here.deepest_sibling = here.depth();
            here.operators = 0;
            here.deepest_bracket = 0;
        } else if (is_operator(token)) {
            ++here.operators;
        }
        if (token.kind == TokenKind::If || token.kind == TokenKind::Let) ++unclosed_words;
        if (token.kind == TokenKind::EndWord && unclosed_words > 0) --unclosed_words;
        const Segment& now = open.back();
        if (now.above + open.size() + now.depth() + unclosed_words > limit) return i;
    }
    return std::nullopt;
}

}  // namespace meld::syntax
