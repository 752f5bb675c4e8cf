// Items end at their full stop. If it is missing, the next one begins with a declaration's keyword at the start of a line, as for the
// parser, or with a fact at the left margin that no comma or operator joins to the text before.
#include "compiler/lsp/items.h"

#include <algorithm>
#include <string_view>

#include "runtime/base/assert.h"

namespace meld::lsp {

namespace {

bool ends_fact(TokenKind kind) {
    switch (kind) {
        case TokenKind::Delay:
        case TokenKind::RightParen:
        case TokenKind::RightBracket:
        case TokenKind::RightBrace:
            return true;
        default:
            return is_atom(kind);
    }
}

std::size_t end_of(const source::File& file, const std::vector<Token>& tokens, std::size_t begin) {
    MELD_EXPECT(begin < tokens.size() && tokens[begin].kind != TokenKind::End, "no item starts at token {}", begin);
    const auto kind = [&](std::size_t i) { return tokens[std::min(i, tokens.size() - 1)].kind; };
    const bool include = kind(begin) == TokenKind::Include || kind(begin) == TokenKind::Use;
    std::size_t at = begin + 1;
    if (kind(begin) == TokenKind::IncludePath || (include && kind(at) == TokenKind::String)) {
        at += include ? 1 : 0;
        if (include && kind(at) == TokenKind::Name && tokens[at].text == "as" && kind(at + 1) == TokenKind::Name) at += 2;
        return kind(at) == TokenKind::Period ? at + 1 : at;
    }
    if (kind(begin) == TokenKind::Period) return at;
    const auto starts_next = [&](std::size_t i) {
        if (!tokens[i].first_on_line) return false;
        const bool fact = kind(i) == TokenKind::Name && kind(i + 1) == TokenKind::LeftParen && file.place(tokens[i].span.begin).column == 1;
        return starts_declaration(kind(i)) || (fact && ends_fact(kind(i - 1)));
    };
    while (kind(at) != TokenKind::End && kind(at) != TokenKind::Period && !starts_next(at)) ++at;
    return kind(at) == TokenKind::Period ? at + 1 : at;
}

// The arrow outside of all brackets.
std::size_t arrow_of(const FileTokens& file, const Item& item) {
    MELD_EXPECT(item.begin < item.end && item.end <= file.tokens.size(), "tokens {} to {}", item.begin, item.end);
    for (std::size_t i = item.begin; i < item.end; ++i) {
        const TokenKind kind = file.tokens[i].kind;
        if (kind == TokenKind::ViewArrow || kind == TokenKind::LinearArrow) return i;
        if (file.partners[i] > i) i = file.partners[i];
    }
    return item.end;
}

std::string_view trimmed(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

// A line of a comment without its marks.
std::string_view bare(std::string_view line) {
    line = trimmed(line);
    if (line.starts_with("//") || line.starts_with("/*") || line.starts_with(";;")) line.remove_prefix(2);
    if (line.ends_with("*/")) line.remove_suffix(2);
    return trimmed(line);
}

}  // namespace

std::optional<std::size_t> FileTokens::item_at(std::size_t offset) const {
    std::optional<std::size_t> found;
    for (std::size_t i = 0; i < items.size() && tokens[items[i].begin].span.begin <= offset; ++i) found = i;
    return found;
}

FileTokens read_items(const source::File& file, std::uint32_t index) {
    diagnostics::Reporter ignored;
    FileTokens result;
    result.tokens = syntax::scan(file, index, ignored);
    syntax::classify_words(result.tokens);
    result.partners = syntax::match_brackets(result.tokens);
    MELD_ASSERT(!result.tokens.empty() && result.tokens.back().kind == TokenKind::End, "the tokens of a file have no end");
    std::size_t at = 0;
    while (result.tokens[at].kind != TokenKind::End) {
        Item item{.begin = at, .end = end_of(file, result.tokens, at)};
        item.kind = starts_declaration(result.tokens[at].kind) ? result.tokens[at].kind : TokenKind::Name;
        item.arrow = arrow_of(result, item);
        MELD_CHECK(item.end > at);
        at = item.end;
        result.items.push_back(item);
    }
    return result;
}

std::string item_text(const source::File& file, const FileTokens& tokens, std::size_t item) {
    MELD_EXPECT(item < tokens.items.size(), "item {} of {}", item, tokens.items.size());
    std::string text;
    std::size_t last = 0;
    for (std::size_t i = tokens.items[item].begin; i < tokens.items[item].end; ++i) {
        const source::Span span = tokens.tokens[i].span;
        if (!text.empty() && span.begin > last) text += ' ';
        text += std::string_view(file.text()).substr(span.begin, span.end - span.begin);
        last = span.end;
    }
    return text;
}

std::string doc_comment(const source::File& file, const FileTokens& tokens, std::size_t item) {
    MELD_EXPECT(item < tokens.items.size(), "item {} of {}", item, tokens.items.size());
    const Item& wanted = tokens.items[item];
    std::vector<std::string_view> lines;
    bool in_block = false;
    for (std::uint32_t line = file.place(tokens.tokens[wanted.begin].span.begin).line; line > 1; --line) {
        const std::string_view above = trimmed(file.line(line - 1));
        const bool ends_block = above.ends_with("*/") && !above.starts_with("//");
        const bool opens_block = above.find("/*") != std::string_view::npos;
        // A comment after the code of another line belongs to that line.
        if (!in_block && !above.starts_with("//") && !above.starts_with(";;") && !above.starts_with("/*") && (opens_block || !ends_block))
            break;
        in_block = (in_block || ends_block) && !opens_block;
        lines.push_back(bare(above));
    }
    std::string text;
    for (auto line = lines.rbegin(); line != lines.rend(); ++line) text += std::string(text.empty() ? "" : "\n") + std::string(*line);
    const std::uint32_t end = tokens.tokens[wanted.end - 1].span.end;
    const source::Place place = file.place(end);
    const std::string_view behind =
        trimmed(file.line(place.line).substr(std::min<std::size_t>(place.column - 1, file.line(place.line).size())));
    if (behind.starts_with("//") || behind.starts_with("/*")) text += (text.empty() ? "" : "\n\n") + std::string(bare(behind));
    return text;
}

}  // namespace meld::lsp
