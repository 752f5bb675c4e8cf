// The depth of an expression is bounded by the depths of the chains of its operators plus that of the deepest bracket in it; that needs no
// tree.
#include "compiler/syntax/nesting.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

#include "compiler/syntax/operators.h"
#include "runtime/base/assert.h"

namespace meld::syntax {

namespace {

// The tokens between two commas at one level of brackets. Operators of one level are a chain; those of a tighter one begin anew behind a
// looser one, since they are in its operands.
class Segment {
  public:
    explicit Segment(std::size_t outside) : above(outside) {}

    // The depth of what is read so far, without brackets, and of all of this level of brackets.
    std::size_t operators() const {
        std::size_t sum = sealed_;
        for (std::size_t level = 0; level < kLevels; ++level) sum += depth_of_chain(static_cast<Level>(level), longest_[level]);
        return sum;
    }
    std::size_t depth() const { return std::max(operators() + deepest_bracket_, deepest_sibling_); }

    void between(Level level) {
        begin_operand(level);
        after_tighter_ = level > Level::Not;
    }
    // In 1 + ~ X = 2 the tilde begins an operand with looser operators in it.
    void before(Level level) {
        if (level == Level::Not && after_tighter_) seal();
        begin_operand(level);
        after_tighter_ = false;
    }
    void word() { ++sealed_; }
    void bracket(std::size_t depth) { deepest_bracket_ = std::max(deepest_bracket_, depth); }
    void separator() {
        deepest_sibling_ = depth();
        sealed_ = deepest_bracket_ = 0;
        run_ = longest_ = {};
        after_tighter_ = false;
    }

    // Operators of the segments around this one.
    std::size_t above;

  private:
    static constexpr std::size_t kLevels = static_cast<std::size_t>(Level::Primary);

    void begin_operand(Level level) {
        const auto at = static_cast<std::size_t>(level);
        std::fill(run_.begin() + static_cast<std::ptrdiff_t>(at) + 1, run_.end(), 0);
        longest_[at] = std::max(longest_[at], ++run_[at]);
    }
    void seal() {
        sealed_ = operators();
        run_ = longest_ = {};
    }

    std::array<std::size_t, kLevels> run_ = {}, longest_ = {};
    std::size_t sealed_ = 0;  // Of operators that are around all that follow.
    std::size_t deepest_bracket_ = 0;
    // The depth of the segments before it at this level.
    std::size_t deepest_sibling_ = 0;
    bool after_tighter_ = false;
};

bool is_separator(TokenKind kind) {
    switch (kind) {
        case TokenKind::Comma:
        case TokenKind::Bar:
        case TokenKind::Semicolon:
        case TokenKind::ViewArrow:
        case TokenKind::LinearArrow:
        case TokenKind::ResultArrow:
        case TokenKind::Then:
        case TokenKind::Else:
        case TokenKind::Otherwise:
        case TokenKind::In:
        case TokenKind::LastArrow:
            return true;
        default:
            return false;
    }
}

// An `if` and a `let` are brackets that `end` closes.
bool is_opening(TokenKind kind) {
    switch (kind) {
        case TokenKind::LeftParen:
        case TokenKind::StructOpen:
        case TokenKind::LeftBracket:
        case TokenKind::NeighbourOpen:
        case TokenKind::LeftBrace:
        case TokenKind::If:
        case TokenKind::Let:
            return true;
        default:
            return false;
    }
}

// Whether an operator behind it stands between two operands.
bool ends_operand(const Token& token) {
    switch (token.kind) {
        case TokenKind::Int:
        case TokenKind::Float:
        case TokenKind::String:
        case TokenKind::Catom:
        case TokenKind::World:
        case TokenKind::RunArgument:
        case TokenKind::AtName:
        case TokenKind::Name:
        case TokenKind::Variable:
        case TokenKind::Anonymous:
        case TokenKind::EndWord:
            return true;
        default:
            return is_closing(token.kind);
    }
}

// The level of an operator, or none.
std::optional<Level> level_of(TokenKind kind) {
    switch (kind) {
        case TokenKind::Or:
            return Level::Or;
        case TokenKind::And:
            return Level::And;
        case TokenKind::Tilde:
            return Level::Not;
        case TokenKind::Equal:
        case TokenKind::NotEqual:
        case TokenKind::Less:
        case TokenKind::LessEqual:
        case TokenKind::Greater:
        case TokenKind::GreaterEqual:
            return Level::Compare;
        case TokenKind::Cons:
            return Level::Cons;
        case TokenKind::Append:
            return Level::Append;
        case TokenKind::Plus:
        case TokenKind::Minus:
            return Level::Add;
        case TokenKind::Star:
        case TokenKind::Slash:
        case TokenKind::Percent:
            return Level::Multiply;
        case TokenKind::Caret:
            return Level::Power;
        default:
            return std::nullopt;
    }
}

// In a declaration, `list list int` nests without brackets.
bool is_word_of_types(const Token& token) {
    return token.kind == TokenKind::Name && (token.text == "list" || token.text == "set" || token.text == "array");
}

}  // namespace

std::optional<std::size_t> too_deep(const std::vector<Token>& tokens, std::size_t begin, std::size_t end, std::size_t limit) {
    MELD_EXPECT(begin <= end && end <= tokens.size(), "tokens {} to {} of {}", begin, end, tokens.size());
    // Each token adds a level at most.
    if (end - begin < limit) return std::nullopt;
    std::vector<Segment> open{Segment(0)};
    bool after_operand = false;
    for (std::size_t i = begin; i < end; ++i) {
        const Token& token = tokens[i];
        Segment& here = open.back();
        if (is_opening(token.kind)) {
            open.emplace_back(here.above + here.operators());
        } else if ((is_closing(token.kind) || token.kind == TokenKind::EndWord) && open.size() > 1) {
            const std::size_t depth = here.depth() + 1;
            open.pop_back();
            open.back().bracket(depth);
        } else if (is_separator(token.kind)) {
            here.separator();
        } else if (const std::optional<Level> level = level_of(token.kind)) {
            if (after_operand)
                here.between(*level);
            else
                here.before(token.kind == TokenKind::Minus ? Level::Negate : *level);
        } else if (is_word_of_types(token)) {
            here.word();
        }
        after_operand = ends_operand(token);
        const Segment& now = open.back();
        if (now.above + open.size() + now.depth() > limit) return i;
    }
    return std::nullopt;
}

}  // namespace meld::syntax
