#include "compiler/syntax/other_languages.h"

#include <algorithm>
#include <iterator>
#include <string_view>

namespace meld::syntax {

namespace {

// Words that other languages have between conditions, and branches of an `if`.
std::string cure_of_word(const std::string& word) {
    if (word == "and") return "write `,` between the clauses of a rule, and `&&` within a condition";
    if (word == "or") return "write `||` within a condition; for clauses, write one rule for each alternative";
    if (word == "where" || word == "when" || word == "if") return "conditions are clauses of the body, with a `,` between them";
    if (word == "elseif" || word == "elif" || word == "elsif") return "write `else if ... then ... else ... end end`";
    return "";
}

// sum X, where an aggregate is no word of its own.
bool is_aggregate_before(const Stop& stop) {
    static constexpr std::string_view kWords[] = {"sum", "min", "max", "count", "avg", "collect"};
    if (stop.at == stop.begin) return false;
    const Token& before = stop.tokens[stop.at - 1];
    return before.kind == TokenKind::Name && std::find(std::begin(kWords), std::end(kWords), before.text) != std::end(kWords);
}

std::string cure_of_semicolon(const Stop& stop) {
    const Token& next = stop.tokens[stop.at + 1];
    if (next.kind == TokenKind::End || next.first_on_line) return "rules and declarations end with a full stop: `.`";
    return "where `;` means or, write one rule for each alternative, or `||` within a condition";
}

}  // namespace

std::string cure_of_other_language(const Stop& stop) {
    const Token& token = stop.tokens[stop.at];
    // The last token of all is the end, which is none of these.
    if (token.kind == TokenKind::End) return "";
    const Token& next = stop.tokens[stop.at + 1];
    // Whether a token of this kind stands right before it.
    const auto behind = [&](TokenKind kind) {
        return stop.at > stop.begin && stop.tokens[stop.at - 1].kind == kind && stop.tokens[stop.at - 1].span.end == token.span.begin;
    };
    if (stop.tokens[stop.begin].kind == TokenKind::Minus && stop.tokens[stop.begin + 1].kind == TokenKind::Minus)
        return "comments start with `//`";
    switch (token.kind) {
        case TokenKind::Name:
            return stop.at > stop.begin ? cure_of_word(token.text) : "";
        case TokenKind::Semicolon:
            return cure_of_semicolon(stop);
        case TokenKind::Colon: {
            // Behind a fact it is the arrow of a rule that was meant.
            const bool assigns = stop.at > stop.begin && stop.tokens[stop.at - 1].kind == TokenKind::Variable;
            return assigns && next.kind == TokenKind::Equal && next.span.begin == token.span.end
                       ? "write `=`: an equality gives a variable its value"
                       : "";
        }
        case TokenKind::Greater:
            return behind(TokenKind::Minus) ? "an arrow is `-o` from a body to its heads, or `:-` from a head to its body" : "";
        case TokenKind::Less:
            return behind(TokenKind::Equal) ? "write `<=`" : "";
        case TokenKind::ResultArrow:
            return "write `>=`";
        case TokenKind::LeftBracket:
            return behind(TokenKind::Variable) ? "`lnth(L, 0)` is the first element of a list L" : "";
        case TokenKind::Variable:
            return is_aggregate_before(stop)
                       ? "an aggregate is declared with its predicate, `type total(node, sum int).`, or is a clause of a\n"
                         "body: `S = sum X : { p(A, X) }`"
                       : "";
        case TokenKind::Percent:
            return stop.at == stop.begin || token.first_on_line ? "comments start with `//`" : "";
        case TokenKind::Equal:
            return stop.tokens[stop.begin].kind == TokenKind::Fun
                       ? "a function declares the type of its result: `fun f(int A) : int = A + 1.`"
                       : "";
        case TokenKind::LeftBrace: {
            const bool value = std::find(stop.expected.begin(), stop.expected.end(), TokenKind::Let) != stop.expected.end();
            return value ? "a set is written as a list where a set is expected, or made from one: `list2set([1, 2])`" : "";
        }
        default:
            return "";
    }
}

}  // namespace meld::syntax
