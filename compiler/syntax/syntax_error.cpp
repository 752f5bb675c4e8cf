// Messages of the parser. The grammar knows dozens of tokens that could follow; a reader wants the two or three that close or continue.
#include "compiler/syntax/syntax_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <string>

#include "compiler/syntax/other_languages.h"
#include "runtime/base/assert.h"

namespace meld::syntax {

using diagnostics::Kind;
using Fit = diagnostics::Edit::Fit;

namespace {

constexpr std::size_t kMaxQuoted = 40;
constexpr std::size_t kMaxExpected = 5;

bool has(const std::vector<TokenKind>& kinds, TokenKind kind) { return std::find(kinds.begin(), kinds.end(), kind) != kinds.end(); }

bool is_declaration(TokenKind kind) { return kind == TokenKind::Type || kind == TokenKind::Extern || kind == TokenKind::Import; }

std::string quoted(std::string text) {
    if (text.size() > kMaxQuoted) {
        text.resize(kMaxQuoted);
        // Names are ASCII; nothing is cut in the middle of a character.
        text += "...";
    }
    return "`" + text + "`";
}

std::string found(const Token& token) {
    switch (token.kind) {
        case TokenKind::Name:
        case TokenKind::Variable:
        case TokenKind::Int:
        case TokenKind::Float:
        case TokenKind::Catom:
        case TokenKind::Hint:
            return quoted(token.text);
        case TokenKind::AtName:
            return quoted(token.text);
        default:
            return std::string(description(token.kind));
    }
}

std::string joined(const std::vector<std::string>& words) {
    std::string result;
    for (std::size_t i = 0; i < words.size(); ++i) {
        if (i > 0) result += i + 1 == words.size() ? " or " : ", ";
        result += words[i];
    }
    return result;
}

// What could follow there, in the words of somebody who writes the language.
std::string expected_words(const std::vector<TokenKind>& expected, TokenKind item) {
    std::vector<std::string> words;
    const auto put = [&](std::string_view word) {
        if (std::find(words.begin(), words.end(), word) == words.end()) words.emplace_back(word);
    };
    const bool goes_on = has(expected, TokenKind::Comma) || has(expected, TokenKind::Period) || has(expected, TokenKind::RightBracket);
    const bool types = has(expected, TokenKind::StructOpen) && has(expected, TokenKind::Name) && !has(expected, TokenKind::Let);
    if (has(expected, TokenKind::Forall)) {
        put("a fact or a condition");
    } else if (has(expected, TokenKind::Let)) {
        put("an expression");
    } else if (types && !goes_on) {
        put(is_declaration(item) && !has(expected, TokenKind::RightParen) && !has(expected, TokenKind::NeighbourOpen) ? "a name"
                                                                                                                      : "a type");
    } else if (!types && !goes_on && has(expected, TokenKind::Name)) {
        put("a name");
    }
    if (!has(expected, TokenKind::Let) && !types && has(expected, TokenKind::Variable)) put("a variable");
    for (const TokenKind kind :
         {TokenKind::Comma, TokenKind::RightParen, TokenKind::RightBracket, TokenKind::RightBrace, TokenKind::Bar, TokenKind::Semicolon,
          TokenKind::ResultArrow, TokenKind::ExistsPeriod, TokenKind::Colon, TokenKind::Then, TokenKind::Else, TokenKind::Otherwise,
          TokenKind::EndWord, TokenKind::ViewArrow, TokenKind::LinearArrow, TokenKind::LastArrow, TokenKind::Period}) {
        if (has(expected, kind)) put(description(kind));
    }
    // Tokens that are allowed in many places are named only if nothing else is: the `in` of a let, the equals sign of a constant.
    for (const TokenKind kind : {TokenKind::In, TokenKind::LeftParen, TokenKind::LeftBracket, TokenKind::LeftBrace, TokenKind::Equal}) {
        if (words.empty() && has(expected, kind)) put(description(kind));
    }
    if (words.empty() && !expected.empty()) put(description(expected.front()));
    if (words.size() > kMaxExpected) words.resize(kMaxExpected);
    return joined(words);
}

// The innermost bracket that is still open where the grammar stopped.
std::optional<std::size_t> open_bracket(const Stop& stop) {
    std::vector<std::size_t> open;
    for (std::size_t i = stop.begin; i < stop.at; ++i) {
        switch (stop.tokens[i].kind) {
            case TokenKind::LeftParen:
            case TokenKind::StructOpen:
            case TokenKind::LeftBracket:
            case TokenKind::NeighbourOpen:
            case TokenKind::LeftBrace:
                open.push_back(i);
                break;
            case TokenKind::RightParen:
            case TokenKind::RightBracket:
            case TokenKind::RightBrace:
                if (!open.empty()) open.pop_back();
                break;
            default:
                break;
        }
    }
    if (open.empty()) return std::nullopt;
    return open.back();
}

std::optional<std::size_t> earlier_arrow(const Stop& stop) {
    for (std::size_t i = stop.begin; i < stop.at; ++i) {
        if (stop.tokens[i].kind == TokenKind::ViewArrow || stop.tokens[i].kind == TokenKind::LinearArrow) return i;
    }
    return std::nullopt;
}

std::string_view closing_of(TokenKind open) {
    return open == TokenKind::LeftBrace ? "}" : open == TokenKind::LeftBracket || open == TokenKind::NeighbourOpen ? "]" : ")";
}
bool is_arrow(TokenKind kind) { return kind == TokenKind::ViewArrow || kind == TokenKind::LinearArrow; }

bool starts_operand(TokenKind kind) {
    switch (kind) {
        case TokenKind::Bang:
        case TokenKind::Question:
        case TokenKind::Dollar:
        case TokenKind::LeftBrace:
        case TokenKind::Not:
        case TokenKind::Forall:
            return true;
        default:
            return is_atom(kind);
    }
}

// Two words in a row at the start of an item: a directive of another implementation, or a misspelt one.
void unknown_declaration(const Token& word, diagnostics::Reporter& report) {
    const std::vector<std::string> known = {"type",   "const",  "fun",      "extern", "node",  "include", "use",  "import",
                                            "export", "module", "priority", "prio",   "index", "compact", "data", "allocator"};
    const std::string near = diagnostics::nearest_name(word.text, known);
    auto& diagnostic = report.add(Kind::SyntaxError, word.span, fmt::format("no declaration starts with `{}`", word.text));
    if (!near.empty()) return diagnostic.did_you_mean(near, word.span);
    diagnostic.help =
        "declarations start with type, const, fun, extern, node, include, use, import, export or module;\n"
        "the hints priority, prio, index, compact, data and allocator are read and have no effect: other directives have to be left out";
}

// Mistakes that are recognized by the token that was found; false if it is none of them.
bool report_known_mistake(const Stop& stop, diagnostics::Reporter& report) {
    const Token& token = stop.tokens[stop.at];
    const std::optional<std::size_t> open = open_bracket(stop);
    if (is_closing(token.kind) && !open) {
        report.add(Kind::SyntaxError, token.span, fmt::format("this {} closes nothing", description(token.kind))).fixes = {
            diagnostics::leave_out(token.span, description(token.kind), Fit::Exact)};
        return true;
    }
    if (is_arrow(token.kind) && !open) {
        if (const auto first = earlier_arrow(stop)) {
            auto& diagnostic = report.add(Kind::SyntaxError, token.span, "a second arrow in one rule");
            diagnostic.labels.push_back({stop.tokens[*first].span, "the first is here"});
            diagnostic.help = "a rule ends with a full stop; is one missing between the two?";
            return true;
        }
    }
    const Token& first = stop.tokens[stop.begin];
    if (first.kind == TokenKind::Name && stop.at == stop.begin + 1 && (is_atom(token.kind) || token.kind == TokenKind::AtName)) {
        unknown_declaration(first, report);
        return true;
    }
    const bool call_of_variable =
        token.kind == TokenKind::LeftParen && stop.at > stop.begin && stop.tokens[stop.at - 1].kind == TokenKind::Variable;
    if (call_of_variable) {
        const Token& name = stop.tokens[stop.at - 1];
        auto& diagnostic =
            report.add(Kind::SyntaxError, name.span, fmt::format("{} is a variable, and a variable has no arguments", quoted(name.text)));
        diagnostic.help = "names of predicates and functions start with a lower-case letter";
        std::string lower = name.text;
        lower[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(lower[0])));
        if (lower != name.text) diagnostic.fixes = {diagnostics::write(name.span, std::move(lower))};
        return true;
    }
    if (token.kind == TokenKind::AtName) {
        report.add(Kind::SyntaxError, token.span, fmt::format("{} means nothing here", quoted(token.text))).help = kBehindAt;
        return true;
    }
    if (token.kind == TokenKind::Include || token.kind == TokenKind::Use) {
        report.add(Kind::SyntaxError, token.span, fmt::format("{} names a file in quotes", description(token.kind))).help =
            fmt::format("{} \"file.meld\".", token.text);
        return true;
    }
    if (token.kind == TokenKind::Catom && has(stop.expected, TokenKind::Delay)) {
        auto& diagnostic = report.add(Kind::SyntaxError, token.span, "a delay is written with a plus sign");
        diagnostic.help = "@+2s for seconds, @+250ms for milliseconds, @+3 for ticks";
        diagnostic.fixes = {diagnostics::insert({token.span.file, token.span.begin + 1, token.span.begin + 1}, "+")};
        return true;
    }
    if (token.kind == TokenKind::Aggregate || token.kind == TokenKind::SizedAggregate) {
        report.add(Kind::SyntaxError, token.span, fmt::format("{} cannot stand here", quoted(token.text))).help =
            "an aggregate is a separate clause of a body: S = sum X : { p(A, X) }";
        return true;
    }
    return false;
}

}  // namespace

void report_syntax_error(const Stop& stop, diagnostics::Reporter& report) {
    MELD_EXPECT(stop.begin <= stop.at && stop.at < stop.tokens.size(), "tokens {} to {} of {}", stop.begin, stop.at, stop.tokens.size());
    if (report_known_mistake(stop, report)) return;
    const Token& token = stop.tokens[stop.at];
    const std::string expected = expected_words(stop.expected, stop.tokens[stop.begin].kind);
    const std::string message =
        expected.empty() ? fmt::format("{} cannot stand here", found(token)) : fmt::format("expected {}, found {}", expected, found(token));
    auto& diagnostic = report.add(Kind::SyntaxError, token.span, message);
    const std::optional<std::size_t> open = open_bracket(stop);
    const bool wrong_closing = is_closing(token.kind) && open && !closes(stop.tokens[*open].kind, token.kind);
    const bool ends = token.kind == TokenKind::Period || token.kind == TokenKind::End || is_arrow(token.kind) || wrong_closing;
    const bool other_arrow = token.kind == TokenKind::Colon || token.kind == TokenKind::ResultArrow;
    Cure cure = cure_of_other_language(stop);
    if (!cure.help.empty()) {
        diagnostic.help = std::move(cure.help);
        if (cure.fix) diagnostic.fixes = {std::move(*cure.fix)};
    } else if (other_arrow && has(stop.expected, TokenKind::ViewArrow)) {
        diagnostic.help = "write head :- body for a view, body -o head for a linear rule";
    } else if (ends && open) {
        const Token& bracket = stop.tokens[*open];
        diagnostic.labels.push_back({bracket.span, fmt::format("this {} is not closed", description(bracket.kind))});
        const Span last = stop.tokens[stop.at - 1].span;
        diagnostic.fixes = {diagnostics::insert({last.file, last.end, last.end}, std::string(closing_of(bracket.kind)))};
    } else if (has(stop.expected, TokenKind::Comma) && starts_operand(token.kind) &&
               (open || stop.tokens[stop.at - 1].kind != TokenKind::Name)) {
        // A name alone is a constant, and no part of a rule.
        diagnostic.help = fmt::format("is a `,` missing before {}?", found(token));
        const Span last = stop.tokens[stop.at - 1].span;
        diagnostic.fixes = {diagnostics::insert({last.file, last.end, last.end}, ",")};
    }
}

void report_missing_period(const std::vector<Token>& tokens, std::size_t begin, std::size_t at, diagnostics::Reporter& report) {
    MELD_EXPECT(begin < at && at < tokens.size(), "tokens {} to {} of {}", begin, at, tokens.size());
    const bool declaration =
        is_declaration(tokens[begin].kind) || tokens[begin].kind == TokenKind::Const || tokens[begin].kind == TokenKind::Fun;
    Span end = tokens[at - 1].span;
    end.begin = end.end;
    auto& diagnostic = report.add(Kind::MissingPeriod, end, fmt::format("this {} has no full stop", declaration ? "declaration" : "rule"));
    diagnostic.help = "put a `.` here";
    diagnostic.fixes = {safe(diagnostics::insert(end, "."))};
    if (tokens[at].kind != TokenKind::End) diagnostic.labels.push_back({tokens[at].span, "the next one starts here"});
}

}  // namespace meld::syntax
