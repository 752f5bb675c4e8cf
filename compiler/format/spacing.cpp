// Blanks depend on the two neighbours and on the kind of the item; for a minus also on whether there is an operand before it.
#include "compiler/format/spacing.h"

#include "compiler/syntax/aggregates.h"
#include "runtime/base/assert.h"

namespace meld::format {

namespace {

enum class ItemKind { Rule, Declaration, Hint };

ItemKind kind_of(const std::vector<Piece>& item) {
    for (const Piece& piece : item) {
        if (piece.comment()) continue;
        switch (piece.token) {
            case TokenKind::Type:
            case TokenKind::Extern:
            case TokenKind::Import:
            case TokenKind::Fun:
                return ItemKind::Declaration;
            case TokenKind::Hint:
                return ItemKind::Hint;
            default:
                return ItemKind::Rule;
        }
    }
    return ItemKind::Rule;
}

bool ends_operand(TokenKind kind) {
    switch (kind) {
        case TokenKind::World:
        case TokenKind::RunArgument:
        case TokenKind::RightParen:
        case TokenKind::RightBracket:
        case TokenKind::EndWord:
            return true;
        default:
            return is_atom(kind);
    }
}

class Spacer {
  public:
    explicit Spacer(const std::vector<Piece>& item) : item_(item), kind_(kind_of(item)) {}

    std::vector<Gap> run() {
        std::vector<Gap> gaps(item_.size());
        TokenKind before_last = TokenKind::End;
        for (std::size_t i = 0; i < item_.size(); ++i) {
            if (i > 0) gaps[i] = gap(item_[i - 1], item_[i], before_last);
            if (closes_bracket(item_[i]) || item_[i].is(TokenKind::EndWord)) --depth_;
            gaps[i].depth = depth_;
            if (opens_bracket(item_[i]) || item_[i].is(TokenKind::If) || item_[i].is(TokenKind::Let)) ++depth_;
            in_value_ = in_value_ || (depth_ == 0 && item_[i].is(TokenKind::Equal));
            if (i > 0 && !item_[i - 1].comment()) before_last = item_[i - 1].token;
        }
        MELD_ENSURE(gaps.size() == item_.size() && (gaps.empty() || !gaps.front().blank), "{} gaps of {} pieces", gaps.size(),
                    item_.size());
        return gaps;
    }

  private:
    Gap gap(const Piece& left, const Piece& right, TokenKind before_left) const {
        const bool separate = blank(left, right, before_left);
        const bool inside_bracket = (opens_bracket(left) && !right.comment()) || closes_bracket(right);
        return {separate, separate || inside_bracket, 0};
    }

    bool blank(const Piece& left, const Piece& right, TokenKind before_left) const {
        // The path of `include #file` goes up to the next blank, full stops included.
        if (left.is(TokenKind::IncludePath) && right.is(TokenKind::Period)) return !left.text.ends_with('"') && !left.text.ends_with('>');
        if (right.is(TokenKind::Comma) || right.is(TokenKind::Period) || right.is(TokenKind::ExistsPeriod) ||
            right.is(TokenKind::Semicolon))
            return false;
        if (left.comment() || right.comment()) return !opens_tightly(left) && !closes_tightly(right);
        if (opens_tightly(left) || closes_tightly(right)) return false;
        if (kind_ == ItemKind::Hint) return left.is(TokenKind::Hint) || left.is(TokenKind::Comma) || right.apart;
        if (left.is(TokenKind::Tilde)) return false;
        // A constant called o would become an arrow.
        if (left.is(TokenKind::Minus) && !ends_operand(before_left)) return right.text == "o";
        if (right.is(TokenKind::LeftParen)) return !calls(left);
        if (right.is(TokenKind::LeftBracket) && left.is(TokenKind::RightParen)) return false;  // forall p(A)[q(A)]
        if (right.is(TokenKind::Delay) || left.is(TokenKind::Cons) || right.is(TokenKind::Cons)) return false;
        if (left.is(TokenKind::Bang) || left.is(TokenKind::Question) || left.is(TokenKind::Dollar)) return false;
        if (left.is(TokenKind::Colon)) return before_left != TokenKind::LeftBracket;  // [:random X | ...]
        return true;
    }

    static bool opens_tightly(const Piece& piece) {
        return piece.is(TokenKind::LeftParen) || piece.is(TokenKind::StructOpen) || piece.is(TokenKind::LeftBracket);
    }
    static bool closes_tightly(const Piece& piece) { return piece.is(TokenKind::RightParen) || piece.is(TokenKind::RightBracket); }

    // p(A) and f(X) are calls, also type p(node) at the outermost level; list (int, int) is a type of a type, and min_k(3) an aggregate
    // with its number.
    bool calls(const Piece& left) const {
        if (left.is(TokenKind::Delta) || left.is(TokenKind::SizedAggregate)) return true;
        if (left.is(TokenKind::Name) && info(syntax::declared_aggregate(left.text)).has(syntax::AggregateInfo::kParameter)) return true;
        return left.is(TokenKind::Name) && (kind_ != ItemKind::Declaration || depth_ == 0 || in_value_);
    }

    const std::vector<Piece>& item_;
    ItemKind kind_;
    int depth_ = 0;
    // Behind the equals sign of a function.
    bool in_value_ = false;
};

}  // namespace

bool opens_bracket(const Piece& piece) {
    return piece.is(TokenKind::LeftParen) || piece.is(TokenKind::StructOpen) || piece.is(TokenKind::LeftBracket) ||
           piece.is(TokenKind::NeighbourOpen) || piece.is(TokenKind::LeftBrace);
}

bool closes_bracket(const Piece& piece) {
    return piece.is(TokenKind::RightParen) || piece.is(TokenKind::RightBracket) || piece.is(TokenKind::RightBrace);
}

std::vector<Gap> gaps_of(const std::vector<Piece>& item) { return Spacer(item).run(); }

}  // namespace meld::format
