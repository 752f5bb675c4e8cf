// Words in context. Meld reserves hardly any word: `type` starts a declaration, but type(A) is a fact; `end` closes an `if`, but end(A) is
// a fact. This pass looks at the neighbours of each word and gives it the kind of a keyword only where nothing else makes sense.
#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <string_view>

#include "compiler/syntax/aggregates.h"
#include "compiler/syntax/tokens.h"
#include "runtime/base/assert.h"

namespace meld::syntax {

namespace {

// An expression may end with this token, so no other expression can start after it.
bool ends_operand(TokenKind kind) {
    switch (kind) {
        case TokenKind::World:
        case TokenKind::RunArgument:
        case TokenKind::Delay:
        case TokenKind::RightParen:
        case TokenKind::RightBracket:
        case TokenKind::RightBrace:
        case TokenKind::EndWord:
            return true;
        default:
            return is_atom(kind);
    }
}

bool is_sigil(TokenKind kind) { return kind == TokenKind::Bang || kind == TokenKind::Question || kind == TokenKind::Dollar; }

TokenKind item_keyword(std::string_view word) {
    if (word == "type") return TokenKind::Type;
    if (word == "const") return TokenKind::Const;
    if (word == "fun") return TokenKind::Fun;
    if (word == "extern") return TokenKind::Extern;
    if (word == "node") return TokenKind::Node;
    if (word == "import") return TokenKind::Import;
    if (word == "export") return TokenKind::Export;
    if (word == "module") return TokenKind::Module;
    if (word == "include") return TokenKind::Include;
    if (word == "use") return TokenKind::Use;
    if (is_one_of(word, {"priority", "prio", "index", "compact", "data", "allocator"})) return TokenKind::Hint;
    return TokenKind::Name;
}

class Classifier {
  public:
    explicit Classifier(std::vector<Token>& tokens) : tokens_(tokens), partners_(match_brackets(tokens)) {}

    void run() {
        for (at_ = 0; at_ < tokens_.size(); ++at_) {
            Token& token = tokens_[at_];
            if (token.kind == TokenKind::Name) token.kind = word(token);
            if (token.kind == TokenKind::Period && closes_exists_) {
                token.kind = TokenKind::ExistsPeriod;
                closes_exists_ = false;
            }
            track_item(token);
        }
    }

  private:
    const Token& token(std::size_t offset) const { return tokens_[std::min(at_ + offset, tokens_.size() - 1)]; }
    TokenKind next(std::size_t offset = 1) const { return token(offset).kind; }
    TokenKind last() const { return at_ == 0 ? TokenKind::Period : tokens_[at_ - 1].kind; }

    // Inside declarations and hints every word is a name; elsewhere the neighbours decide.
    TokenKind word(const Token& name) {
        if (item_start_ || starts_forgotten_item(name)) {
            const TokenKind keyword = item_keyword(name.text);
            if (keyword != TokenKind::Name && is_item_start(keyword)) return keyword;
        }
        return in_declaration_ ? TokenKind::Name : rule_word(name.text);
    }

    // The word at the start of an item is a keyword unless a fact of that name stands there.
    bool is_item_start(TokenKind keyword) const {
        const TokenKind follower = next();
        if (keyword == TokenKind::Node) return follower == TokenKind::Name && next(2) != TokenKind::LeftParen;
        if (keyword == TokenKind::Type && follower == TokenKind::LeftParen) return tuple_alias();
        const bool fact_or_head =
            follower == TokenKind::LeftParen || follower == TokenKind::ViewArrow || follower == TokenKind::LinearArrow;
        return !fact_or_head;
    }

    // `type (int, int) pair.` and not the fact `type(A, 1).`: a name stands behind the closing bracket.
    bool tuple_alias() const {
        const std::size_t close = partners_[at_ + 1];
        return close != 0 && tokens_[close + 1].kind == TokenKind::Name;
    }

    // A declaration on a new line whose predecessor has no full stop: two words in a row are nothing else.
    bool starts_forgotten_item(const Token& name) const {
        if (!name.first_on_line || in_let_or_if(next(), token(1).text)) return false;
        // `extern type handle.` on two lines.
        if (name.text == "type" && last() == TokenKind::Extern) return false;
        if (is_one_of(name.text, {"include", "use"})) return next() == TokenKind::String;
        if (name.text == "const") return (next() == TokenKind::Name || next() == TokenKind::Variable) && next(2) == TokenKind::Equal;
        return is_one_of(name.text, {"type", "fun", "extern", "export", "import"}) && next() == TokenKind::Name;
    }

    static bool in_let_or_if(TokenKind kind, std::string_view text) {
        return kind == TokenKind::Name && is_one_of(text, {"then", "else", "otherwise", "end", "in"});
    }

    TokenKind rule_word(std::string_view word) {
        const bool after_operand = ends_operand(last());
        if (after_operand) {
            if (word == "then") return TokenKind::Then;
            if (word == "else") return TokenKind::Else;
            if (word == "otherwise") return TokenKind::Otherwise;
            if (word == "end") return TokenKind::EndWord;
            if (word == "in") return TokenKind::In;
            return TokenKind::Name;
        }
        if (word == "if") return starts_condition() ? TokenKind::If : TokenKind::Name;
        if (word == "let") return next() == TokenKind::Variable && next(2) == TokenKind::Equal ? TokenKind::Let : TokenKind::Name;
        if (word == "not")
            return next() == TokenKind::Name || next() == TokenKind::LeftParen || is_sigil(next()) ? TokenKind::Not : TokenKind::Name;
        if (word == "forall") return next() == TokenKind::Name || is_sigil(next()) ? TokenKind::Forall : TokenKind::Name;
        if (word == "delta" && next() == TokenKind::LeftParen && next(3) == TokenKind::Semicolon) return TokenKind::Delta;
        // The manual of Linear Meld has `create` for `exists`.
        if (is_one_of(word, {"exists", "create"}) && (next() == TokenKind::Variable || next() == TokenKind::Anonymous)) {
            closes_exists_ = true;
            return TokenKind::Exists;
        }
        if (makes_values()) closes_exists_ = true;
        if (starts_sized_aggregate(word)) return TokenKind::SizedAggregate;
        return starts_aggregate() ? TokenKind::Aggregate : TokenKind::Name;
    }

    // `if` is a keyword, but if(...) without a later `then` is a fact or a call.
    bool starts_condition() const {
        if (next() != TokenKind::LeftParen) return true;
        // Far more tokens than a condition has; the limit keeps invalid text from costing quadratic time.
        const std::size_t limit = std::min(tokens_.size(), at_ + 300);
        for (std::size_t i = at_ + 1; i < limit; ++i) {
            const Token& token = tokens_[i];
            if (token.kind == TokenKind::Name && token.text == "then" && ends_operand(tokens_[i - 1].kind)) return true;
            if (ends_clause(token.kind)) return false;
            if (token.kind == TokenKind::LeftParen || token.kind == TokenKind::LeftBracket || token.kind == TokenKind::StructOpen) {
                i = std::max(i, partners_[i]);
            }
        }
        return true;
    }

    static bool ends_clause(TokenKind kind) {
        switch (kind) {
            case TokenKind::Comma:
            case TokenKind::Period:
            case TokenKind::ViewArrow:
            case TokenKind::LinearArrow:
            case TokenKind::LastArrow:
            case TokenKind::Bar:
            case TokenKind::RightParen:
            case TokenKind::RightBracket:
            case TokenKind::RightBrace:
            case TokenKind::Delay:
            case TokenKind::End:
                return true;
            default:
                return false;
        }
    }

    // The `sum` of S = sum X : { ... }: behind an equals sign, and before something a name cannot stand before.
    bool starts_aggregate() const {
        if (last() != TokenKind::Equal) return false;
        const TokenKind follower = next();
        if (follower == TokenKind::LeftParen) {
            const std::size_t close = partners_[at_ + 1];
            return close != 0 && tokens_[close + 1].kind == TokenKind::Colon;
        }
        if (follower == TokenKind::Name) return !in_let_or_if(follower, token(1).text) && !token(1).first_on_line;
        if (follower == TokenKind::Variable) return !token(1).first_on_line || next(2) == TokenKind::Colon;
        return follower == TokenKind::Colon || follower == TokenKind::Int || follower == TokenKind::Float ||
               follower == TokenKind::Anonymous;
    }

    // The `min_k` of L = min_k(3) X : { ... }: an operand stands right behind the number's closing bracket.
    bool starts_sized_aggregate(std::string_view word) const {
        if (last() != TokenKind::Equal || next() != TokenKind::LeftParen) return false;
        if (!info(aggregate_of_matches(word)).has(AggregateInfo::kParameter)) return false;
        const std::size_t close = partners_[at_ + 1];
        if (close == 0) return false;
        const Token& value = tokens_[close + 1];
        const bool opens =
            value.kind == TokenKind::LeftParen || value.kind == TokenKind::StructOpen || value.kind == TokenKind::LeftBracket;
        return opens || (is_atom(value.kind) && !in_let_or_if(value.kind, value.text));
    }

    // create B, C. (...), another word for `exists`: the grammar refuses it, and what is in brackets is part of the rule.
    bool makes_values() const {
        std::size_t offset = 1;
        for (; next(offset) == TokenKind::Variable; offset += 2)
            if (next(offset + 1) != TokenKind::Comma)
                return next(offset + 1) == TokenKind::Period && next(offset + 2) == TokenKind::LeftParen &&
                       !token(offset + 2).first_on_line;
        return false;
    }

    // A full stop or an include ends an item; a declaration keyword starts one that has no keywords inside.
    void track_item(const Token& token) {
        switch (token.kind) {
            case TokenKind::Period:
            case TokenKind::IncludePath:
                item_start_ = true;
                in_declaration_ = false;
                closes_exists_ = false;
                return;
            case TokenKind::Type:
            case TokenKind::Extern:
            case TokenKind::Node:
            case TokenKind::Import:
            case TokenKind::Export:
            case TokenKind::Module:
            case TokenKind::Hint:
                in_declaration_ = true;
                break;
            case TokenKind::Const:
            case TokenKind::Fun:
                in_declaration_ = false;
                break;
            case TokenKind::String:
                // include "x" and use "x" end here, with or without a full stop, unless `as` and a name follow.
                if (last() == TokenKind::Include || last() == TokenKind::Use) {
                    in_declaration_ = next() == TokenKind::Name && this->token(1).text == "as";
                    item_start_ = !in_declaration_;
                    return;
                }
                break;
            default:
                break;
        }
        item_start_ = false;
    }

    std::vector<Token>& tokens_;
    std::vector<std::size_t> partners_;
    std::size_t at_ = 0;
    bool item_start_ = true;
    bool in_declaration_ = false;
    // Behind `exists X` until its full stop, which ends no item.
    bool closes_exists_ = false;
};

}  // namespace

bool closes(TokenKind open, TokenKind close) {
    switch (close) {
        case TokenKind::RightParen:
            return open == TokenKind::LeftParen || open == TokenKind::StructOpen;
        case TokenKind::RightBracket:
            return open == TokenKind::LeftBracket || open == TokenKind::NeighbourOpen;
        case TokenKind::RightBrace:
            return open == TokenKind::LeftBrace;
        default:
            return false;
    }
}

std::vector<std::size_t> match_brackets(const std::vector<Token>& tokens) {
    std::vector<std::size_t> partners(tokens.size(), 0);
    std::vector<std::size_t> open;
    for (std::size_t i = 0; i < tokens.size(); ++i) {
        switch (tokens[i].kind) {
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
                if (!open.empty() && closes(tokens[open.back()].kind, tokens[i].kind)) {
                    partners[open.back()] = i;
                    partners[i] = open.back();
                    open.pop_back();
                }
                break;
            // No bracket extends over a full stop, except that of `exists X. (` inside a comprehension, which no caller needs.
            case TokenKind::Period:
                open.clear();
                break;
            default:
                break;
        }
    }
    MELD_ENSURE(partners.size() == tokens.size(), "{} partners of {} tokens", partners.size(), tokens.size());
    return partners;
}

namespace {

// A name with `-` at its end, `over-(A)`, looks like a difference. It is a name where the file declares it, in an item that
// starts with `type`: then its two tokens become one, everywhere in the file.
class TrailingHyphens {
  public:
    explicit TrailingHyphens(std::vector<Token>& tokens) : tokens_(tokens) {}

    void run() {
        bool start = true, declaration = false;
        for (std::size_t i = 0; i < tokens_.size(); ++i) {
            if (start) declaration = tokens_[i].kind == TokenKind::Name && tokens_[i].text == "type";
            start = tokens_[i].kind == TokenKind::Period;
            if (declaration && ends_with_hyphen(i)) names_.insert(tokens_[i].text);
        }
        if (names_.empty()) return;
        std::size_t kept = 0;
        for (std::size_t i = 0; i < tokens_.size(); ++i) {
            const bool joins = ends_with_hyphen(i) && names_.contains(tokens_[i].text);
            Token token = std::move(tokens_[i]);
            if (joins) {
                token.text += '-';
                token.span.end = tokens_[++i].span.end;
            }
            MELD_ASSERT(kept <= i, "token {} of {} goes to {}", i, tokens_.size(), kept);
            tokens_[kept++] = std::move(token);
        }
        tokens_.resize(kept);
    }

  private:
    // name-( without blanks
    bool ends_with_hyphen(std::size_t i) const {
        return i + 2 < tokens_.size() && tokens_[i].kind == TokenKind::Name && tokens_[i + 1].kind == TokenKind::Minus &&
               tokens_[i + 2].kind == TokenKind::LeftParen && tokens_[i].span.end == tokens_[i + 1].span.begin &&
               tokens_[i + 1].span.end == tokens_[i + 2].span.begin;
    }

    std::vector<Token>& tokens_;
    std::set<std::string> names_;
};

}  // namespace

void classify_words(std::vector<Token>& tokens) {
    TrailingHyphens(tokens).run();
    Classifier(tokens).run();
}

}  // namespace meld::syntax
