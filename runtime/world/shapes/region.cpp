// Regions: parsed once into a small tree of tests, evaluated once per catom.
//
//   region     = conjunction { "||" conjunction }
//   conjunction = test { "&&" test }
//   test       = "!" test | "(" region ")" | "all" | "inside" "(" shape ")"
//              | "cell" ("==" | "!=") "(" integer "," integer "," integer ")"
//              | variable [ "%" integer ] comparison number          variable: id x y z robot
//              | ("part" | "assembly") ("==" | "!=") word
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>

#include "runtime/base/did_you_mean.h"
#include "runtime/world/shapes/expression.h"
#include "runtime/world/shapes/region_id.h"
#include "runtime/world/shapes/robots.h"

namespace meld::world {
namespace {

using Child = std::shared_ptr<const Region::Node>;

struct AnyOf {
    std::vector<Child> tests;
};
struct AllOf {
    std::vector<Child> tests;
};
struct Not {
    Child test;
};
struct Everybody {};
struct Inside {
    Shape shape;
};
struct AtCell {
    Cell cell;
    bool equal;
};

enum class Variable { Id, X, Y, Z };
enum class Comparison { Equal, Unequal, Less, LessEqual, Greater, GreaterEqual };

struct Compare {
    Variable variable;
    std::int64_t modulus;  // 0: none.
    Comparison comparison;
    double number;
};

// Tests of catoms that are parts of robots; no other catom passes them.
struct OfRobot {
    std::shared_ptr<const Robots> robots;
    Compare number;  // Its variable means nothing.
};
struct OfAssembly {
    std::shared_ptr<const Robots> robots;
    std::uint32_t assembly;
    bool equal;
};
struct IsPart {
    std::shared_ptr<const Robots> robots;
    std::vector<std::optional<std::uint32_t>> parts;  // By assembly: which part has the name.
    bool equal;
};

}  // namespace

struct Region::Node {
    std::variant<AnyOf, AllOf, Not, Everybody, Inside, AtCell, Compare, OfRobot, OfAssembly, IsPart> test;
};

namespace {

struct Catom {
    std::uint64_t id;
    Cell cell;
    const Vec3& position;
};

bool holds(const Child& test, const Catom& catom);

bool holds(const AnyOf& t, const Catom& catom) {
    return std::any_of(t.tests.begin(), t.tests.end(), [&catom](const Child& test) { return holds(test, catom); });
}
bool holds(const AllOf& t, const Catom& catom) {
    return std::all_of(t.tests.begin(), t.tests.end(), [&catom](const Child& test) { return holds(test, catom); });
}
bool holds(const Not& t, const Catom& catom) { return !holds(t.test, catom); }
bool holds(const Everybody&, const Catom&) { return true; }
bool holds(const Inside& t, const Catom& catom) { return t.shape.contains(catom.position); }
bool holds(const AtCell& t, const Catom& catom) { return (t.cell == catom.cell) == t.equal; }

// Ids are below 2^63.
std::int64_t value_of(Variable variable, const Catom& catom) {
    switch (variable) {
        case Variable::Id:
            return static_cast<std::int64_t>(catom.id);
        case Variable::X:
            return catom.cell.x;
        case Variable::Y:
            return catom.cell.y;
        case Variable::Z:
            break;
    }
    return catom.cell.z;
}

bool compares(const Compare& t, std::int64_t value) {
    // The remainder of a negative coordinate is positive, so that every n-th cell is selected across zero too.
    if (t.modulus != 0) value = ((value % t.modulus) + t.modulus) % t.modulus;
    const double number = static_cast<double>(value);
    switch (t.comparison) {
        case Comparison::Equal:
            return number == t.number;
        case Comparison::Unequal:
            return number != t.number;
        case Comparison::Less:
            return number < t.number;
        case Comparison::LessEqual:
            return number <= t.number;
        case Comparison::Greater:
            return number > t.number;
        case Comparison::GreaterEqual:
            break;
    }
    return number >= t.number;
}

bool holds(const Compare& t, const Catom& catom) { return compares(t, value_of(t.variable, catom)); }
bool holds(const OfRobot& t, const Catom& catom) {
    const std::optional<RobotPart> part = t.robots->of(catom.id);
    return part && compares(t.number, static_cast<std::int64_t>(part->robot));
}
bool holds(const OfAssembly& t, const Catom& catom) {
    const std::optional<RobotPart> part = t.robots->of(catom.id);
    return part && (part->assembly == t.assembly) == t.equal;
}
bool holds(const IsPart& t, const Catom& catom) {
    const std::optional<RobotPart> part = t.robots->of(catom.id);
    return part && (t.parts[part->assembly] == part->part) == t.equal;
}

bool holds(const Child& test, const Catom& catom) {
    return std::visit([&catom](const auto& t) { return holds(t, catom); }, test->test);
}

template <class Test>
Child make(Test test) {
    return std::make_shared<const Region::Node>(Region::Node{std::move(test)});
}

struct Sign {
    std::string_view text;
    Comparison comparison;
};
constexpr std::array<Sign, 6> kSigns = {{{"==", Comparison::Equal},
                                         {"!=", Comparison::Unequal},
                                         {"<", Comparison::Less},
                                         {"<=", Comparison::LessEqual},
                                         {">", Comparison::Greater},
                                         {">=", Comparison::GreaterEqual}}};

Parsed<std::int64_t> parse_integer(Cursor& cursor, std::string_view what) {
    const std::size_t column = cursor.peek().column;
    const Parsed<double> number = parse_signed(cursor);
    if (!number) return cursor.expected(what);
    // Beyond 2^53 a double no longer holds each integer.
    if (*number != std::trunc(*number) || std::abs(*number) > 0x1p53) {
        return tl::unexpected(ExpressionError{column, fmt::format("{} is not {}", *number, what), {}});
    }
    return static_cast<std::int64_t>(*number);
}

Parsed<Child> parse_cell(Cursor& cursor) {
    const bool equal = cursor.accept("==");
    if (!equal && !cursor.accept("!=")) return cursor.expected("'==' or '!='");
    std::array<std::int64_t, 3> coordinate{};
    for (std::size_t i = 0; i < 3; ++i) {
        if (!cursor.accept(i == 0 ? "(" : ",")) return cursor.expected(i == 0 ? "a cell, (x, y, z)" : "','");
        const std::size_t column = cursor.peek().column;
        const Parsed<std::int64_t> value = parse_integer(cursor, "an integer");
        if (!value) return tl::unexpected(value.error());
        if (*value < -kCellLimit || *value >= kCellLimit) {
            return tl::unexpected(
                ExpressionError{column, fmt::format("coordinate {} is not between {} and {}", *value, -kCellLimit, kCellLimit - 1), {}});
        }
        coordinate[i] = *value;
    }
    if (!cursor.accept(")")) return cursor.expected("')'");
    const auto part = [&coordinate](std::size_t i) { return static_cast<std::int32_t>(coordinate[i]); };
    return make(AtCell{{part(0), part(1), part(2)}, equal});
}

Parsed<Compare> parse_compare(Cursor& cursor, Variable variable) {
    Compare test = {variable, 0, Comparison::Equal, 0};
    if (cursor.accept("%")) {
        const std::size_t column = cursor.peek().column;
        const Parsed<std::int64_t> modulus = parse_integer(cursor, "an integer");
        if (!modulus) return tl::unexpected(modulus.error());
        if (*modulus <= 0) return tl::unexpected(ExpressionError{column, "the number after '%' must be above zero", {}});
        test.modulus = *modulus;
    }
    const auto sign = std::find_if(kSigns.begin(), kSigns.end(), [&cursor](const Sign& s) { return cursor.at(s.text); });
    if (sign == kSigns.end()) {
        auto wrong = cursor.expected("a comparison, == != < <= > or >=");
        if (cursor.at("=")) wrong.value().suggestion = "write ==";
        return wrong;
    }
    cursor.take();
    test.comparison = sign->comparison;
    const Parsed<double> number = parse_signed(cursor);
    if (!number) return tl::unexpected(number.error());
    test.number = *number;
    return test;
}

Parsed<Child> parse_comparison(Cursor& cursor, Variable variable) {
    return parse_compare(cursor, variable).map([](const Compare& test) { return make(test); });
}

// After `part` or `assembly`: whether what follows is to be the same, and the name.
struct WordTest {
    bool equal = true;
    Token name;
};
Parsed<WordTest> parse_name(Cursor& cursor, std::string_view example) {
    WordTest named{cursor.accept("=="), {}};
    if (!named.equal && !cursor.accept("!=")) {
        auto wrong = cursor.expected("'==' or '!='");
        if (cursor.at("=")) wrong.value().suggestion = "write ==";
        return wrong;
    }
    if (cursor.peek().kind != TokenKind::Word && cursor.peek().kind != TokenKind::Name)
        return cursor.expected(fmt::format("a name, as in {}", example));
    named.name = cursor.take();
    return named;
}

Parsed<Child> parse_part(Cursor& cursor) {
    const Parsed<WordTest> named = parse_name(cursor, "part == left");
    if (!named) return tl::unexpected(named.error());
    IsPart test{cursor.robots(), {}, named->equal};
    std::vector<std::string_view> known;
    for (const Assembly& assembly : test.robots->assemblies()) {
        test.parts.push_back(assembly.part_named(named->name.text));
        known.insert(known.end(), assembly.parts.begin(), assembly.parts.end());
    }
    if (std::ranges::none_of(test.parts, [](const auto& part) { return part.has_value(); }))
        return tl::unexpected(ExpressionError{named->name.column, fmt::format("no assembly has a part '{}'", named->name.text),
                                              did_you_mean(named->name.text, known)});
    return make(std::move(test));
}

Parsed<Child> parse_assembly(Cursor& cursor) {
    const Parsed<WordTest> named = parse_name(cursor, "assembly == two_wheeler");
    if (!named) return tl::unexpected(named.error());
    const std::vector<Assembly>& all = cursor.robots()->assemblies();
    const auto found = std::ranges::find(all, named->name.text, &Assembly::name);
    if (found != all.end()) return make(OfAssembly{cursor.robots(), static_cast<std::uint32_t>(found - all.begin()), named->equal});
    std::vector<std::string_view> known;
    for (const Assembly& assembly : all) known.emplace_back(assembly.name);
    return tl::unexpected(ExpressionError{named->name.column, fmt::format("there is no assembly '{}'", named->name.text),
                                          did_you_mean(named->name.text, known)});
}

// A test of robots, whose word has been taken.
Parsed<Child> parse_of_robots(Cursor& cursor, const Token& word) {
    if (!cursor.robots())
        return tl::unexpected(ExpressionError{word.column, fmt::format("this world has no robots, so no catom has a '{}'", word.text),
                                              "describe a robot by [[assembly]] and place it by [[body]] assembly = \"NAME\""});
    if (word.text == "part") return parse_part(cursor);
    if (word.text == "assembly") return parse_assembly(cursor);
    return parse_compare(cursor, Variable::Id).map([&](const Compare& test) { return make(OfRobot{cursor.robots(), test}); });
}

Parsed<Child> parse_region(Cursor& cursor);

Parsed<Child> parse_named(Cursor& cursor) {
    static constexpr std::array<std::string_view, 10> kWords = {"id", "x", "y", "z", "cell", "all", "inside", "part", "robot", "assembly"};
    if (cursor.peek().kind != TokenKind::Word) return cursor.expected("a test such as id == 4, cell == (0, 0, 0) or inside(sphere(4))");
    const Token name = cursor.take();
    if (name.text == "id") return parse_comparison(cursor, Variable::Id);
    if (name.text == "x") return parse_comparison(cursor, Variable::X);
    if (name.text == "y") return parse_comparison(cursor, Variable::Y);
    if (name.text == "z") return parse_comparison(cursor, Variable::Z);
    if (name.text == "cell") return parse_cell(cursor);
    if (name.text == "all") return make(Everybody{});
    if (name.text == "part" || name.text == "robot" || name.text == "assembly") return parse_of_robots(cursor, name);
    if (name.text != "inside") {
        return tl::unexpected(
            ExpressionError{name.column, fmt::format("nothing is called '{}' here", name.text), did_you_mean(name.text, kWords)});
    }
    if (!cursor.accept("(")) return cursor.expected("'(' as in inside(sphere(4))");
    Parsed<Shape> shape = parse_shape(cursor);
    if (!shape) return tl::unexpected(shape.error());
    if (!cursor.accept(")")) return cursor.expected("')'");
    return make(Inside{std::move(*shape)});
}

Parsed<Child> parse_test(Cursor& cursor) {
    const std::size_t column = cursor.peek().column;
    const bool negated = cursor.accept("!");
    if (!negated && !cursor.accept("(")) return parse_named(cursor);
    if (++cursor.depth > Cursor::kMaxDepth) {
        return tl::unexpected(ExpressionError{column, fmt::format("regions are nested more than {} deep", Cursor::kMaxDepth), {}});
    }
    Parsed<Child> inner = negated ? parse_test(cursor) : parse_region(cursor);
    --cursor.depth;
    if (!inner) return inner;
    if (negated) return make(Not{*inner});
    if (!cursor.accept(")")) return cursor.expected("'&&', '||' or ')'");
    return inner;
}

// One or more operands with `sign` between them.
template <class Combined>
Parsed<Child> parse_list(Cursor& cursor, std::string_view sign, Parsed<Child> (*operand)(Cursor&)) {
    Combined combined;
    do {
        Parsed<Child> test = operand(cursor);
        if (!test) return test;
        combined.tests.push_back(std::move(*test));
    } while (cursor.accept(sign));
    return combined.tests.size() == 1 ? combined.tests[0] : make(std::move(combined));
}

Parsed<Child> parse_conjunction(Cursor& cursor) { return parse_list<AllOf>(cursor, "&&", parse_test); }
Parsed<Child> parse_region(Cursor& cursor) { return parse_list<AnyOf>(cursor, "||", parse_conjunction); }

}  // namespace

Parsed<Region> parse_region_text(const std::string& text, Nameable nameable) {
    Parsed<std::vector<Token>> tokens = tokenize(text);
    if (!tokens) return tl::unexpected(tokens.error());
    Cursor cursor(std::move(*tokens), std::move(nameable));
    Parsed<Child> test = parse_region(cursor);
    if (!test) return tl::unexpected(test.error());
    if (cursor.peek().kind != TokenKind::End) return cursor.expected("'&&', '||' or nothing more");
    return Region(std::move(*test), text);
}

Result<Region> Region::parse(const std::string& text) {
    return parse_region_text(text).map_error([](const ExpressionError& error) { return error.error(); });
}

bool Region::contains(std::uint64_t id, Cell cell, const Vec3& position) const { return !root_ || holds(root_, Catom{id, cell, position}); }

std::optional<std::uint64_t> named_id(const Region& region) {
    const Parsed<std::vector<Token>> tokens = tokenize(region.text());
    if (!tokens || tokens->size() != 4 || (*tokens)[0].text != "id" || (*tokens)[1].text != "==") return std::nullopt;
    const Token& number = (*tokens)[2];
    // Beyond 2^53 a double no longer holds each integer.
    if (number.kind != TokenKind::Number || number.number != std::trunc(number.number) || number.number > 0x1p53) return std::nullopt;
    return static_cast<std::uint64_t>(number.number);
}

}  // namespace meld::world
