// Reads the small expressions of a world file, shapes and regions: words, numbers, quoted names and signs, each with its column.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/world/model/solid.h"
#include "runtime/world/shapes/robots.h"
#include "runtime/world/shapes/shape.h"

namespace meld::world {

// What is wrong with an expression and where: columns count bytes from 1.
struct ExpressionError {
    std::size_t column = 1;
    std::string problem;
    std::string suggestion = {};

    // "column 7: problem".
    Error error() const;
};

template <class T>
using Parsed = tl::expected<T, ExpressionError>;

enum class TokenKind { Word, Number, Name, Sign, End };

struct Token {
    TokenKind kind = TokenKind::End;
    std::string_view text;  // Of the expression, which must outlive it; of a name, without its quotes.
    double number = 0;
    std::size_t column = 1;
};

// Opens the models that shapes name.
class ModelFiles {
  public:
    virtual ~ModelFiles() = default;
    virtual Result<std::shared_ptr<const model::Solid>> open(std::string_view name) = 0;
};

// What expressions may name that is not their own; null where there is none.
struct Nameable {
    ModelFiles* models = nullptr;
    std::shared_ptr<const Robots> robots = {};
};

// The tokens of an expression, the last of which is End. Names are in single or double quotes. Signs are
// ( ) , = == != < <= > >= && || ! % and a lone -. Errors: a byte that starts no token; a number that is not finite; a quote
// without its second.
Parsed<std::vector<Token>> tokenize(std::string_view text);

// A position in the tokens of one expression, moved forward by parsing.
class Cursor {
  public:
    Cursor(std::vector<Token> tokens, Nameable nameable) : tokens_(std::move(tokens)), nameable_(std::move(nameable)) {}
    ModelFiles* models() const { return nameable_.models; }
    const std::shared_ptr<const Robots>& robots() const { return nameable_.robots; }
    const Token& peek(std::size_t ahead = 0) const;
    const Token& last() const { return tokens_[next_ - 1]; }  // The last token taken.
    bool at(std::string_view sign) const { return is(peek(), sign); }
    bool accept(std::string_view sign);
    Token take();
    tl::unexpected<ExpressionError> expected(std::string_view what) const;  // "expected what, found 'this'".

    // The maximum nesting of parentheses: far more than anybody writes, far less than the stack holds.
    static constexpr int kMaxDepth = 200;
    int depth = 0;

  private:
    static bool is(const Token& token, std::string_view sign) { return token.kind == TokenKind::Sign && token.text == sign; }
    std::vector<Token> tokens_;
    Nameable nameable_;
    std::size_t next_ = 0;
};

// A number with an optional minus before it.
Parsed<double> parse_signed(Cursor& cursor);
// The shape that starts at the cursor.
Parsed<Shape> parse_shape(Cursor& cursor);
// A whole text that must be one shape, or one region.
Parsed<Shape> parse_shape_text(std::string_view text, Nameable nameable = {});
Parsed<Region> parse_region_text(const std::string& text, Nameable nameable = {});

}  // namespace meld::world
