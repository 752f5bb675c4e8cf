// Parses a shape: name ( argument , ... ), arguments by position or by name, checked against the catalogue.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "runtime/base/did_you_mean.h"
#include "runtime/world/shapes/expression.h"
#include "runtime/world/shapes/shape_catalogue.h"

namespace meld::world {
namespace {

using Done = Parsed<bool>;

tl::unexpected<ExpressionError> wrong(std::size_t column, std::string problem, std::string suggestion = {}) {
    return tl::unexpected(ExpressionError{column, std::move(problem), std::move(suggestion)});
}

Parsed<const ShapeEntry*> find_entry(const Token& name) {
    std::vector<std::string_view> known;
    for (const ShapeEntry& entry : shape_catalogue()) {
        if (entry.name == name.text) return &entry;
        known.push_back(entry.name);
    }
    return wrong(name.column, fmt::format("there is no shape '{}'", name.text), did_you_mean(name.text, known));
}

// Reads the arguments of one shape.
class ArgumentReader {
  public:
    ArgumentReader(Cursor& cursor, const ShapeEntry& entry) : cursor_(cursor), entry_(entry), given_(entry.parameters.size(), false) {
        arguments_.number.resize(entry.parameters.size());
    }

    // From after the opening parenthesis to after the closing one.
    Parsed<Arguments> read() {
        if (!cursor_.at(")")) {
            do {
                const Parsed<std::size_t> parameter = next_parameter();
                if (!parameter) return tl::unexpected(parameter.error());
                if (const Done done = read_one(*parameter); !done) return tl::unexpected(done.error());
            } while (cursor_.accept(","));
        }
        const std::size_t end = cursor_.peek().column;
        if (!cursor_.accept(")")) return cursor_.expected("',' or ')'");
        for (std::size_t i = 0; i < given_.size(); ++i) {
            const Parameter& parameter = entry_.parameters[i];
            if (given_[i] || parameter.optional || parameter.kind == ParameterKind::MoreShapes) continue;
            return wrong(end, fmt::format("{} lacks its argument {}", entry_.name, parameter.name),
                         fmt::format("write {}", entry_.usage()));
        }
        return std::move(arguments_);
    }

  private:
    // The parameter for the next argument; a name and its '=' are consumed.
    Parsed<std::size_t> next_parameter() {
        const Token token = cursor_.peek();
        const bool named = token.kind == TokenKind::Word && cursor_.peek(1).kind == TokenKind::Sign && cursor_.peek(1).text == "=";
        if (!named) return next_by_place();
        std::vector<std::string_view> names;
        for (std::size_t i = 0; i < given_.size(); ++i) {
            const Parameter& parameter = entry_.parameters[i];
            if (parameter.kind == ParameterKind::MoreShapes) continue;
            names.push_back(parameter.name);
            if (parameter.name != token.text) continue;
            if (given_[i]) return wrong(token.column, fmt::format("argument {} is given twice", token.text));
            cursor_.take();
            cursor_.take();
            by_name_ = true;
            return i;
        }
        return wrong(token.column, fmt::format("{} has no argument '{}'", entry_.name, token.text), did_you_mean(token.text, names));
    }

    Parsed<std::size_t> next_by_place() {
        const std::size_t column = cursor_.peek().column;
        if (by_name_) return wrong(column, "an argument without a name follows one with a name", "name it too");
        for (std::size_t i = 0; i < given_.size(); ++i) {
            if (!given_[i] || entry_.parameters[i].kind == ParameterKind::MoreShapes) return i;
        }
        return wrong(column,
                     fmt::format("{} has {} argument{}, here is one more", entry_.name, given_.size(), given_.size() == 1 ? "" : "s"),
                     fmt::format("write {}", entry_.usage()));
    }

    Done read_one(std::size_t at) {
        given_[at] = true;
        switch (entry_.parameters[at].kind) {
            case ParameterKind::ShapeArgument:
            case ParameterKind::MoreShapes:
                return read_shape();
            case ParameterKind::Axis:
                return read_axis(at);
            case ParameterKind::Model:
                return read_model();
            default:
                return read_number(at);
        }
    }

    Done read_shape() {
        Parsed<Shape> shape = parse_shape(cursor_);
        if (!shape) return tl::unexpected(shape.error());
        arguments_.shapes.push_back(std::move(*shape));
        return true;
    }

    Done read_axis(std::size_t at) {
        const std::string_view text = cursor_.peek().text;
        if (text != "x" && text != "y" && text != "z") return cursor_.expected("an axis, x, y or z");
        arguments_.number[at] = cursor_.take().text[0] - 'x';
        return true;
    }

    Done read_model() {
        const Token name = cursor_.peek();
        if (name.kind != TokenKind::Name) return cursor_.expected(fmt::format("a file in quotes, as in {}('part.stl', ...)", entry_.name));
        if (!cursor_.models()) return wrong(name.column, "only a world file can name models");
        cursor_.take();
        Result<std::shared_ptr<const model::Solid>> model = cursor_.models()->open(name.text);
        if (!model) return wrong(name.column, model.error().problem, model.error().suggestion);
        arguments_.file = name.text;
        arguments_.model = std::move(*model);
        return true;
    }

    Done read_number(std::size_t at) {
        const Parameter& parameter = entry_.parameters[at];
        const std::size_t column = cursor_.peek().column;
        const Parsed<double> number = parse_signed(cursor_);
        if (!number) return cursor_.expected(fmt::format("a number for {} of {}", parameter.name, entry_.usage()));
        if (parameter.kind == ParameterKind::Length && !(*number > 0)) {
            return wrong(column, fmt::format("{} = {} of {} is not above zero", parameter.name, *number, entry_.name));
        }
        if (parameter.kind == ParameterKind::Radius && !(*number >= 0)) {
            return wrong(column, fmt::format("{} = {} of {} is below zero", parameter.name, *number, entry_.name));
        }
        arguments_.number[at] = *number;
        return true;
    }

    Cursor& cursor_;
    const ShapeEntry& entry_;
    std::vector<bool> given_;
    bool by_name_ = false;
    Arguments arguments_;
};

// "cylinder(2, 3)" with one blank where the source had any, for Shape::text(). Names in quotes stay as they are.
std::string tidy(std::string_view text) {
    std::string result;
    char quote = 0;
    for (const char c : text) {
        if (quote != 0 || c == '\'' || c == '"') {
            result += c;
            quote = quote == 0 ? c : c == quote ? char{0} : quote;
            continue;
        }
        const bool blank = c == ' ' || c == '\t' || c == '\n' || c == '\r';
        if (!blank) result += c;
        if (c == ',') result += ' ';
    }
    return result;
}

}  // namespace

Parsed<Shape> parse_shape(Cursor& cursor) {
    if (cursor.peek().kind != TokenKind::Word) return cursor.expected("a shape");
    const Token name = cursor.take();
    const Parsed<const ShapeEntry*> entry = find_entry(name);
    if (!entry) return tl::unexpected(entry.error());
    if (!cursor.accept("(")) return cursor.expected(fmt::format("'(' as in {}", (*entry)->usage()));
    if (++cursor.depth > Cursor::kMaxDepth)
        return wrong(name.column, fmt::format("shapes are nested more than {} deep", Cursor::kMaxDepth));
    const Parsed<Arguments> arguments = ArgumentReader(cursor, **entry).read();
    if (!arguments) return tl::unexpected(arguments.error());
    --cursor.depth;
    auto solid = (*entry)->make(*arguments);
    if (!solid) return wrong(name.column, fmt::format("{}: {}", name.text, solid.error()));
    const char* end = cursor.last().text.data() + cursor.last().text.size();
    return make_shape(std::move(*solid), tidy({name.text.data(), end}));
}

Parsed<Shape> parse_shape_text(std::string_view text, Nameable nameable) {
    Parsed<std::vector<Token>> tokens = tokenize(text);
    if (!tokens) return tl::unexpected(tokens.error());
    Cursor cursor(std::move(*tokens), std::move(nameable));
    Parsed<Shape> shape = parse_shape(cursor);
    if (shape && cursor.peek().kind != TokenKind::End) return cursor.expected("nothing more");
    return shape;
}

}  // namespace meld::world
