#include "compiler/syntax/other_languages.h"

#include <algorithm>

namespace meld::syntax {

namespace {

// Words that other languages have between conditions, and branches of an `if`.
std::string cure_of_word(const std::string& word) {
    if (word == "and") return "write `,` between the clauses of a rule, and `&&` within a condition";
    if (word == "or") return "write `||` within a condition; for clauses, write a rule for each way";
    if (word == "elseif" || word == "elif" || word == "elsif") return "write `else if ... then ... else ... end end`";
    return "";
}

std::string cure_of_semicolon(const Stop& stop) {
    const Token& next = stop.tokens[stop.at + 1];
    if (next.kind == TokenKind::End || next.first_on_line) return "rules and declarations end with a full stop: `.`";
    return "where `;` means or, write a rule for each way, or `||` within a condition";
}

}  // namespace

std::string cure_of_other_language(const Stop& stop) {
    const Token& token = stop.tokens[stop.at];
    // The last token of all is the end, which is none of these.
    if (token.kind == TokenKind::End) return "";
    const Token& next = stop.tokens[stop.at + 1];
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
        case TokenKind::Percent:
            return stop.at == stop.begin || token.first_on_line ? "comments start with `//`" : "";
        case TokenKind::Equal:
            return stop.tokens[stop.begin].kind == TokenKind::Fun ? "a function says the type of its value: `fun f(int A) : int = A + 1.`"
                                                                  : "";
        case TokenKind::LeftBrace: {
            const bool value = std::find(stop.expected.begin(), stop.expected.end(), TokenKind::Let) != stop.expected.end();
            return value ? "a set is written as a list where a set is wanted, or made of one: `list2set([1, 2])`" : "";
        }
        default:
            return "";
    }
}

}  // namespace meld::syntax
