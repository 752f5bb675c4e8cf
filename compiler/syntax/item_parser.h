// The connection between the generated grammar and the rest: the tokens of one item, and where the grammar could not continue.
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "compiler/syntax/parts.h"
#include "compiler/syntax/tokens.h"
#include "runtime/base/assert.h"

namespace meld::syntax {

// Feeds the tokens of an item up to and including the first full stop, then the end.
class ItemTokens {
  public:
    explicit ItemTokens(const std::vector<Token>& tokens) : tokens_(tokens) {}

    // Starts an item. If `stop` is given, a full stop is inserted before that token.
    void start(std::size_t begin, std::optional<std::size_t> stop) {
        MELD_EXPECT(begin < tokens_.size() && (!stop || (begin < *stop && *stop < tokens_.size())), "an item at {} of {}", begin,
                    tokens_.size());
        next_ = begin;
        last_ = begin;
        stop_ = stop;
        ended_ = false;
        expected_.clear();
    }

    const Token& next() {
        if (ended_) return tokens_.back();
        if (stop_ && next_ == *stop_) {
            ended_ = true;
            period_.kind = TokenKind::Period;
            period_.span = tokens_[next_ - 1].span;
            period_.span.begin = period_.span.end;
            return period_;
        }
        MELD_ASSERT(next_ < tokens_.size(), "token {} of {}", next_, tokens_.size());
        const Token& token = tokens_[next_];
        last_ = next_;
        if (token.kind == TokenKind::Period) ended_ = true;
        if (token.kind != TokenKind::End) ++next_;
        return token;
    }
    // The grammar met a token that it could not use: the one given last.
    void fail(std::vector<TokenKind> expected) { expected_ = std::move(expected); }

    // After the last token given, once the item is read.
    std::size_t end() const { return next_; }
    // The index of the token last given.
    std::size_t current() const { return last_; }
    const std::vector<TokenKind>& expected() const { return expected_; }

  private:
    const std::vector<Token>& tokens_;
    std::size_t next_ = 0;
    std::size_t last_ = 0;
    std::optional<std::size_t> stop_;
    Token period_;
    bool ended_ = false;
    std::vector<TokenKind> expected_;
};

namespace grammar {
class Parser;
}

// Runs the grammar over one item after another. The generated parser is reused, because its stack is far larger than an item.
class ItemParser {
  public:
    ItemParser(const std::vector<Token>& tokens, Builder& build);
    ~ItemParser();
    // Reads the item that starts there into the builder. False if no item has this form; then item() gives the place and what was expected.
    bool parse(std::size_t begin, std::optional<std::size_t> stop = std::nullopt);
    const ItemTokens& item() const { return item_; }

  private:
    ItemTokens item_;
    std::unique_ptr<grammar::Parser> parser_;
};

Atom with_sigil(Atom atom, Sigil sigil, Span span);

}  // namespace meld::syntax
