// The seam between the generated grammar and the rest: the tokens of one item, and where the grammar could not go on.
#pragma once

#include <optional>
#include <vector>

#include "compiler/syntax/parts.h"
#include "compiler/syntax/tokens.h"

namespace meld::syntax {

// Feeds the tokens from `begin` up to and with the first full stop, then the end. With `stop` given it feeds a full stop of its own
// before that token.
class ItemTokens {
  public:
    ItemTokens(const std::vector<Token>& tokens, std::size_t begin, std::optional<std::size_t> stop = std::nullopt)
        : tokens_(tokens), next_(begin), last_(begin), stop_(stop) {}

    const Token& next() {
        if (ended_) return tokens_.back();
        if (stop_ && next_ == *stop_) {
            ended_ = true;
            period_.kind = TokenKind::Period;
            period_.span = tokens_[next_ - 1].span;
            period_.span.begin = period_.span.end;
            return period_;
        }
        const Token& token = tokens_[next_];
        last_ = next_;
        if (token.kind == TokenKind::Period) ended_ = true;
        if (token.kind != TokenKind::End) ++next_;
        return token;
    }
    // The grammar met a token it could not use: the one last given.
    void fail(std::vector<TokenKind> expected) { expected_ = std::move(expected); }

    // Behind the last token given, once the item is read.
    std::size_t end() const { return next_; }
    // The index of the token last given.
    std::size_t current() const { return last_; }
    const std::vector<TokenKind>& expected() const { return expected_; }

  private:
    const std::vector<Token>& tokens_;
    std::size_t next_;
    std::size_t last_;
    std::optional<std::size_t> stop_;
    Token period_;
    bool ended_ = false;
    std::vector<TokenKind> expected_;
};

// Runs the grammar over one item, which it adds to the builder. False if the item has no such form.
bool parse_item(ItemTokens& tokens, Builder& build);

Atom with_sigil(Atom atom, Sigil sigil, Span span);

}  // namespace meld::syntax
