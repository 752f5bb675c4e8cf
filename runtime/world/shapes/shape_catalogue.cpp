// The table of shapes. A new solid is a row here and three functions in solids.cpp.
#include "runtime/world/shapes/shape_catalogue.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "runtime/base/assert.h"
#include "runtime/world/shapes/campus.h"
#include "runtime/world/shapes/expression.h"

namespace meld::world {
namespace {

using Made = tl::expected<Solid, std::string>;
using enum ParameterKind;

Made make_cone(const Arguments& a) {
    if (a[0] == 0 && a[1] == 0) return tl::unexpected(std::string("r1 and r2 are both 0"));
    return Cone{a[0], a[1], a[2] / 2};
}

Made make_helix(const Arguments& a) { return Helix{a[0], a[1] / (2 * std::numbers::pi), a[1] * a[2] / 2, a[3] / 2}; }

Made make_gyroid(const Arguments& a) {
    const double wave = 2 * std::numbers::pi / a.value_or(2, a[0] / 2);
    return Gyroid{a[0] / 2, wave, std::numbers::sqrt3 * wave * a[1] / 2};
}

Made make_trumpet(const Arguments& a) {
    const double wall = a.value_or(2, 2);
    const double bell = a.value_or(1, std::max(a[0] / 3, wall));
    if (bell < wall) return tl::unexpected(fmt::format("bell = {} is less than wall = {}", bell, wall));
    return Trumpet{a[0], bell, wall};
}

Made make_campus(const Arguments& a) {
    const Parsed<Shape> campus = parse_shape_text(kCampus);
    MELD_CHECK(campus.has_value(), "{}", campus.error().error().message());
    return Scaled{*campus, a[0] / kCampusLength};
}

// What there is to know of a model before one can say how large it is to be.
std::string extent_of(const Arguments& a) {
    const Vec3 &low = a.model->low(), &high = a.model->high();
    return fmt::format("'{}' is {:.6g} x {:.6g} x {:.6g} units, from ({:.6g}, {:.6g}, {:.6g}) to ({:.6g}, {:.6g}, {:.6g})", a.file,
                       high[0] - low[0], high[1] - low[1], high[2] - low[2], low[0], low[1], low[2], high[0], high[1], high[2]);
}

Made make_model(const Arguments& a) {
    const bool sized = a.number[1].has_value(), scaled = a.number[2].has_value();
    if (sized == scaled)
        return tl::unexpected(fmt::format("{}; give {} size = diameters of its longest side, or scale = diameters of a unit", extent_of(a),
                                          sized ? "only one of" : "either"));
    if (scaled) return Modelled{a.model, 1 / a[2], {}};
    const Vec3 &low = a.model->low(), &high = a.model->high();
    const double longest = a.model->longest_side();
    if (!(longest > 0)) return tl::unexpected(extent_of(a) + ", which has no size");
    return Modelled{
        a.model, longest / a[1], {std::midpoint(low[0], high[0]), std::midpoint(low[1], high[1]), std::midpoint(low[2], high[2])}};
}

Made make_difference(const Arguments& a) { return Difference{a.shapes[0], {a.shapes.begin() + 1, a.shapes.end()}}; }

// Quarter turns are exact, so that a rotated box contains the cells one expects.
Made make_rotated(const Arguments& a) {
    const double quarters = std::fmod(a[2], 360) / 90;
    double sine = std::sin(quarters * std::numbers::pi / 2), cosine = std::cos(quarters * std::numbers::pi / 2);
    if (quarters == std::trunc(quarters)) {
        sine = std::round(sine);
        cosine = std::round(cosine);
    }
    return Rotated{a.shapes[0], static_cast<std::size_t>(a[1]), sine, cosine};
}

const std::vector<ShapeEntry>& entries() {
    static const std::vector<ShapeEntry> kEntries = {
        {"box", {{"x"}, {"y"}, {"z"}}, [](const Arguments& a) -> Made { return BoxSolid{{a[0] / 2, a[1] / 2, a[2] / 2}}; }},
        {"sphere", {{"r"}}, [](const Arguments& a) -> Made { return Ball{a[0]}; }},
        {"ellipsoid", {{"a"}, {"b"}, {"c"}}, [](const Arguments& a) -> Made { return Ellipsoid{{a[0], a[1], a[2]}}; }},
        {"torus", {{"R"}, {"r"}}, [](const Arguments& a) -> Made { return Torus{a[0], a[1]}; }},
        {"cylinder", {{"r"}, {"h"}}, [](const Arguments& a) -> Made { return Cylinder{a[0], a[1] / 2}; }},
        {"cone", {{"r1", Radius}, {"r2", Radius}, {"h"}}, make_cone},
        {"helix", {{"r"}, {"pitch"}, {"turns"}, {"thickness"}}, make_helix},
        {"gyroid", {{"size"}, {"thickness"}, {"period", Length, true}}, make_gyroid},
        {"trumpet", {{"length"}, {"bell", Length, true}, {"wall", Length, true}}, make_trumpet},
        {"campus", {{"size"}}, make_campus},
        {"mesh", {{"file", Model}, {"size", Length, true}, {"scale", Length, true}}, make_model},
        {"union", {{"shape", ShapeArgument}, {"shapes", MoreShapes}}, [](const Arguments& a) -> Made { return Union{a.shapes}; }},
        {"intersect",
         {{"shape", ShapeArgument}, {"shapes", MoreShapes}},
         [](const Arguments& a) -> Made { return Intersection{a.shapes}; }},
        {"minus", {{"shape", ShapeArgument}, {"shapes", MoreShapes}}, make_difference},
        {"shell", {{"shape", ShapeArgument}, {"thickness"}}, [](const Arguments& a) -> Made { return Shell{a.shapes[0], a[1]}; }},
        {"move",
         {{"shape", ShapeArgument}, {"x", Number}, {"y", Number}, {"z", Number, true}},
         [](const Arguments& a) -> Made { return Moved{a.shapes[0], {a[1], a[2], a.value_or(3, 0)}}; }},
        {"rotate", {{"shape", ShapeArgument}, {"axis", Axis}, {"degrees", Number}}, make_rotated},
        {"scale", {{"shape", ShapeArgument}, {"f"}}, [](const Arguments& a) -> Made { return Scaled{a.shapes[0], a[1]}; }},
    };
    return kEntries;
}

}  // namespace

std::string ShapeEntry::usage() const {
    std::string text = fmt::format("{}(", name);
    for (const Parameter& parameter : parameters) {
        if (&parameter != parameters.data()) text += ", ";
        text += parameter.kind == MoreShapes ? "..." : parameter.name;
        if (parameter.optional) text += " = ...";
    }
    return text + ")";
}

std::span<const ShapeEntry> shape_catalogue() { return entries(); }

}  // namespace meld::world
