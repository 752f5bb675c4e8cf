// The scanner of shapes and regions, and the cursor over its tokens.
#include "runtime/world/shapes/expression.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace meld::world {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

std::size_t word_length(std::string_view text) {
    std::size_t length = 0;
    while (length < text.size() && (is_letter(text[length]) || is_digit(text[length]))) ++length;
    return length;
}

std::size_t sign_length(std::string_view text) {
    for (const std::string_view sign : {"==", "!=", "<=", ">=", "&&", "||"}) {
        if (text.starts_with(sign)) return 2;
    }
    return std::string_view("(),=<>!%-").find(text[0]) != std::string_view::npos ? 1 : 0;
}

// How a byte is shown in a message, whatever it is.
std::string shown(char c) {
    return c > ' ' && c < 0x7f ? fmt::format("'{}'", c) : fmt::format("byte 0x{:02x}", static_cast<unsigned char>(c));
}

// Reads the number at the start of `text` into a token without place.
Parsed<Token> scan_number(std::string_view text, std::size_t column) {
    Token token = {TokenKind::Number, {}, 0, column};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), token.number);
    const auto length = static_cast<std::size_t>(end - text.data());
    if (error != std::errc() || !std::isfinite(token.number)) {
        return tl::unexpected(ExpressionError{column, "a number is too large or too small", "use a length between 1e-300 and 1e300"});
    }
    token.text = text.substr(0, length);
    const std::string_view rest = text.substr(length);
    if (!rest.empty() && (is_letter(rest[0]) || rest[0] == '.')) {
        const std::string_view word = text.substr(0, length + std::max<std::size_t>(1, word_length(rest)));
        return tl::unexpected(ExpressionError{column, fmt::format("'{}' is not a number", word), {}});
    }
    return token;
}

}  // namespace

Error ExpressionError::error() const { return {fmt::format("column {}: {}", column, problem), suggestion}; }

Parsed<std::vector<Token>> tokenize(std::string_view text) {
    std::vector<Token> tokens;
    std::size_t at = 0;
    while (true) {
        while (at < text.size() && is_space(text[at])) ++at;
        if (at == text.size()) break;
        const std::string_view rest = text.substr(at);
        Token token = {TokenKind::Sign, {}, 0, at + 1};
        if (is_digit(rest[0]) || (rest[0] == '.' && rest.size() > 1 && is_digit(rest[1]))) {
            Parsed<Token> number = scan_number(rest, at + 1);
            if (!number) return tl::unexpected(number.error());
            token = *number;
        } else if (is_letter(rest[0])) {
            token.kind = TokenKind::Word;
            token.text = rest.substr(0, word_length(rest));
        } else if (rest[0] == '\'' || rest[0] == '"') {
            const std::size_t end = rest.find(rest[0], 1);
            if (end == std::string_view::npos) return tl::unexpected(ExpressionError{at + 1, "a quote has no second one", {}});
            token.kind = TokenKind::Name;
            token.text = rest.substr(1, end - 1);
            at += 2;
        } else {
            token.text = rest.substr(0, sign_length(rest));
            if (token.text.empty()) return tl::unexpected(ExpressionError{at + 1, fmt::format("{} cannot stand here", shown(rest[0])), {}});
        }
        at += token.text.size();
        tokens.push_back(token);
    }
    tokens.push_back({TokenKind::End, {}, 0, text.size() + 1});
    return tokens;
}

const Token& Cursor::peek(std::size_t ahead) const { return tokens_[std::min(next_ + ahead, tokens_.size() - 1)]; }

bool Cursor::accept(std::string_view sign) {
    if (!at(sign)) return false;
    ++next_;
    return true;
}

Token Cursor::take() {
    const Token token = peek();
    if (token.kind != TokenKind::End) ++next_;
    return token;
}

tl::unexpected<ExpressionError> Cursor::expected(std::string_view what) const {
    const Token& found = peek();
    const std::string there = found.kind == TokenKind::End ? "the end" : fmt::format("'{}'", found.text);
    return tl::unexpected(ExpressionError{found.column, fmt::format("expected {}, found {}", what, there), {}});
}

Parsed<double> parse_signed(Cursor& cursor) {
    const bool negative = cursor.accept("-");
    if (cursor.peek().kind != TokenKind::Number) return cursor.expected("a number");
    const double number = cursor.take().number;
    return negative ? -number : number;
}

}  // namespace meld::world
