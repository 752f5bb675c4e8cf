#include "compiler/syntax/other_languages.h"

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

namespace meld::syntax {

namespace {

using diagnostics::safe;
using diagnostics::write;
using Fit = diagnostics::Edit::Fit;

bool expects(const Stop& stop, TokenKind kind) {
    return std::find(stop.expected.begin(), stop.expected.end(), kind) != stop.expected.end();
}

// Words that other languages have between conditions, and branches of an `if`.
Cure cure_of_word(const Stop& stop) {
    const std::string& word = stop.tokens[stop.at].text;
    if (word == "and")
        return {"write `,` between the clauses of a rule, and `&&` within a condition", write(stop.tokens[stop.at].span, ",", Fit::Sign)};
    if (word == "or") return {"write `||` within a condition; for clauses, write one rule for each alternative"};
    if (word == "where" || word == "when" || word == "if")
        return {"conditions are clauses of the body, with a `,` between them", write(stop.tokens[stop.at].span, ",", Fit::Sign)};
    if (word == "ins") return {"write `lexistss(X, Y)` for `X ins Y`"};
    if (word == "elseif" || word == "elif" || word == "elsif") return {"write `else if ... then ... else ... end end`"};
    return {};
}

// sum X, where an aggregate is no word of its own.
bool is_aggregate_before(const Stop& stop) {
    static constexpr std::string_view kAggregateWords[] = {"sum", "min", "max", "count", "avg", "collect"};
    if (stop.at == stop.begin) return false;
    const Token& before = stop.tokens[stop.at - 1];
    return before.kind == TokenKind::Name &&
           std::find(std::begin(kAggregateWords), std::end(kAggregateWords), before.text) != std::end(kAggregateWords);
}

// max(D : ...
bool is_called_aggregate(const Stop& stop) {
    static constexpr std::string_view kCalled[] = {"sum", "min", "max", "count", "avg", "collect"};
    if (stop.at < stop.begin + 3) return false;
    const std::string& word = stop.tokens[stop.at - 3].text;
    return stop.tokens[stop.at - 1].kind == TokenKind::Variable && stop.tokens[stop.at - 2].kind == TokenKind::LeftParen &&
           std::ranges::find(kCalled, word) != std::end(kCalled);
}

// N = count p(A).
bool has_aggregate(const Stop& stop) {
    for (std::size_t i = stop.begin; i < stop.at; ++i)
        if (stop.tokens[i].kind == TokenKind::Aggregate) return true;
    return false;
}

// create B, C. (...)
bool is_before_new_values(const Stop& stop) {
    if (stop.at == stop.begin || stop.tokens[stop.at - 1].kind != TokenKind::Name) return false;
    std::size_t i = stop.at;
    while (stop.tokens[i].kind == TokenKind::Variable && stop.tokens[i + 1].kind == TokenKind::Comma) i += 2;
    return stop.tokens[i].kind == TokenKind::Variable && stop.tokens[i + 1].kind == TokenKind::ExistsPeriod;
}

Cure cure_of_semicolon(const Stop& stop) {
    if (!stop.next_starts_item) return {"where `;` means or, write one rule for each alternative, or `||` within a condition"};
    Cure cure{"rules and declarations end with a full stop: `.`"};
    if (stop.at > stop.begin) cure.fix = safe(write(stop.tokens[stop.at].span, ".", Fit::Sign));
    return cure;
}

}  // namespace

Cure cure_of_other_language(const Stop& stop) {
    const Token& token = stop.tokens[stop.at];
    // The last token of all is the end, which is none of these.
    if (token.kind == TokenKind::End) return {};
    const Token& next = stop.tokens[stop.at + 1];
    // Whether a token of this kind stands right before it.
    const auto behind = [&](TokenKind kind) {
        return stop.at > stop.begin && stop.tokens[stop.at - 1].kind == kind && stop.tokens[stop.at - 1].span.end == token.span.begin;
    };
    const Token& first = stop.tokens[stop.begin];
    if (first.kind == TokenKind::Minus && stop.tokens[stop.begin + 1].kind == TokenKind::Minus)
        return {"comments start with `//`", safe(write(first.span.to(stop.tokens[stop.begin + 1].span), "//"))};
    switch (token.kind) {
        case TokenKind::Name:
            if (stop.expected.size() == 1 && expects(stop, TokenKind::LeftBrace) && has_aggregate(stop)) return {kAggregateClause};
            return stop.at > stop.begin ? cure_of_word(stop) : Cure{};
        case TokenKind::Semicolon:
            return cure_of_semicolon(stop);
        case TokenKind::Colon: {
            // Behind a fact it is the arrow of a rule that was meant.
            if (is_called_aggregate(stop)) return {kAggregateClause};
            const bool assigns = stop.at > stop.begin && stop.tokens[stop.at - 1].kind == TokenKind::Variable;
            if (!assigns || next.kind != TokenKind::Equal || next.span.begin != token.span.end) return {};
            return {"write `=`: an equality gives a variable its value", safe(write(token.span.to(next.span), "="))};
        }
        case TokenKind::LastArrow:
            return {"an arrow is `-o` from a body to its heads, or `:-` from a head to its body"};
        case TokenKind::Less:
            if (!behind(TokenKind::Equal)) return {};
            return {"write `<=`", safe(write(stop.tokens[stop.at - 1].span.to(token.span), "<="))};
        case TokenKind::ResultArrow:
            // Behind a head it is the arrow of a rule that was meant.
            if (stop.at > stop.begin && stop.tokens[stop.at - 1].kind == TokenKind::RightParen && expects(stop, TokenKind::ViewArrow))
                return {};
            return {"write `>=`", safe(write(token.span, ">="))};
        case TokenKind::LeftBracket:
            return behind(TokenKind::Variable) ? Cure{"`lnth(L, 0)` is the first element of a list L"} : Cure{};
        case TokenKind::Variable:
            if (is_before_new_values(stop))
                return {"new values are made by `exists B, C. (...)`", write(stop.tokens[stop.at - 1].span, "exists")};
            if (!is_aggregate_before(stop)) return {};
            return {
                "an aggregate is declared with its predicate, `type total(node, sum int).`, or is a clause of a\n"
                "body: `S = sum X : { p(A, X) }`"};
        case TokenKind::Percent:
            if (stop.at != stop.begin && !token.first_on_line) return {};
            return {"comments start with `//`", safe(write(token.span, "//"))};
        case TokenKind::Equal:
            if (first.kind != TokenKind::Fun) return {};
            return {"a function declares the type of its result: `fun f(int A) : int = A + 1.`"};
        case TokenKind::LeftBrace: {
            if (!expects(stop, TokenKind::Let)) return {};
            return {"a set is written as a list where a set is expected, or made from one: `list2set([1, 2])`"};
        }
        default:
            return expects(stop, TokenKind::Colon) && has_aggregate(stop) ? Cure{kAggregateClause} : Cure{};
    }
}

}  // namespace meld::syntax
