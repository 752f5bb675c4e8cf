// The shapes that an expression can name, their arguments, and how they are made.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "runtime/world/shapes/shape_tree.h"

namespace meld::world {

enum class ParameterKind {
    Length,  // Above zero.
    Radius,  // Zero or above.
    Number,
    ShapeArgument,
    MoreShapes,  // Any number of shapes, at least none; only as the last parameter.
    Axis,        // x, y or z; held as 0, 1 or 2.
    Model,       // The name of a file, in quotes.
};

struct Parameter {
    std::string_view name;
    ParameterKind kind = ParameterKind::Length;
    bool optional = false;
};

// The arguments of one shape in the order of its parameters; an omitted optional argument is empty.
struct Arguments {
    std::vector<std::optional<double>> number;
    std::vector<Shape> shapes;
    std::string file;  // The model's name as it is written, and the model.
    std::shared_ptr<const model::Solid> model = nullptr;
    double operator[](std::size_t parameter) const { return number[parameter].value(); }
    double value_or(std::size_t parameter, double fallback) const { return number[parameter].value_or(fallback); }
};

struct ShapeEntry {
    std::string_view name;
    std::vector<Parameter> parameters;
    // The solid, or what is wrong with this combination of arguments.
    tl::expected<Solid, std::string> (*make)(const Arguments& arguments);
    // "cylinder(r, h)".
    std::string usage() const;
};

std::span<const ShapeEntry> shape_catalogue();

}  // namespace meld::world
