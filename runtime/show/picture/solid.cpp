#include "runtime/show/picture/solid.h"

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "runtime/show/render/cells.h"

namespace meld::picture {

namespace {

using render::Form;
using render::Rgb;
using render::Vec;

// More balls than this have fewer faces.
constexpr std::size_t kFew = 2'000, kMany = 40'000;

// What all catoms have, around their middles, for a diameter of 1.
struct Shape {
    std::vector<Vec> corners, normals;
    std::vector<std::array<std::uint32_t, 3>> faces;
};

Shape icosahedron() {
    const float a = 1 / std::sqrt(1 + std::numbers::phi_v<float> * std::numbers::phi_v<float>), b = a * std::numbers::phi_v<float>;
    Shape out;
    for (const float s : {-a, a})
        for (const float t : {-b, b})
            for (const Vec& corner : {Vec(0, s, t), Vec(s, t, 0), Vec(t, 0, s)}) out.normals.push_back(corner);
    // A side is as long as the shortest way between two corners; any three corners that have such sides are a face.
    const auto near = [&](std::size_t i, std::size_t j) { return (out.normals[i] - out.normals[j]).norm() < 2.1F * a; };
    for (std::uint32_t i = 0; i < 12; ++i)
        for (std::uint32_t j = i + 1; j < 12; ++j)
            for (std::uint32_t k = j + 1; k < 12; ++k) {
                if (!near(i, j) || !near(j, k) || !near(i, k)) continue;
                const Vec& first = out.normals[i];
                const bool outside = (out.normals[j] - first).cross(out.normals[k] - first).dot(first) > 0;
                out.faces.push_back(outside ? std::array{i, j, k} : std::array{i, k, j});
            }
    return out;
}

// Each face in four, with the new corners on the ball.
void refine(Shape& shape) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
        const auto [at, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(shape.normals.size()));
        if (is_new) shape.normals.push_back((shape.normals[a] + shape.normals[b]).normalized());
        return at->second;
    };
    for (const auto& [a, b, c] : std::exchange(shape.faces, {})) {
        const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
        shape.faces.insert(shape.faces.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
}

Shape ball(std::size_t how_many) {
    Shape out = icosahedron();
    for (int i = how_many > kMany ? 2 : how_many > kFew ? 1 : 0; i < 2; ++i) refine(out);
    for (const Vec& normal : out.normals) out.corners.push_back(normal / 2);
    return out;
}

// Hexagons have corners between their neighbours.
Shape polygon(int sides, float radius) {
    Shape out;
    for (int i = 0; i < sides; ++i) {
        const float angle = static_cast<float>(2 * i + 1) * std::numbers::pi_v<float> / static_cast<float>(sides);
        out.corners.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
        out.normals.push_back(Vec::UnitZ());
        if (i > 1) out.faces.push_back({0, static_cast<std::uint32_t>(i - 1), static_cast<std::uint32_t>(i)});
    }
    return out;
}

// The side of a cube that looks along an axis.
Shape side(const Vec& normal) {
    const Vec u(normal.y(), normal.z(), normal.x()), v = normal.cross(u);
    Shape out{.corners = {normal - u - v, normal + u - v, normal + u + v, normal - u + v},
              .normals = {4, normal},
              .faces = {{0, 1, 2}, {0, 2, 3}}};
    for (Vec& corner : out.corners) corner /= 2;
    return out;
}

// A cube with round edges: on each side a grid whose outer lines go around the edges, as far as the middle of each.
Shape rounded(std::size_t how_many) {
    // Where grid lines leave the smaller cube, and how much they lean from there.
    struct Line {
        float at, lean;
    };
    constexpr float kInner = 0.5F - render::kRound, kHalf = 0.41421356F;  // The tangent of half of 45 degrees.
    std::vector<Line> lines = {{-kInner, -1}, {-kInner, 0}, {kInner, 0}, {kInner, 1}};
    if (how_many <= kFew) lines = {{-kInner, -1}, {-kInner, -kHalf}, {-kInner, 0}, {kInner, 0}, {kInner, kHalf}, {kInner, 1}};
    const auto side_length = static_cast<std::uint32_t>(lines.size());
    Shape out;
    for (const Vec& axis : render::kAxes) {
        const Vec u(axis.y(), axis.z(), axis.x()), v = axis.cross(u);
        const auto first = static_cast<std::uint32_t>(out.corners.size());
        for (const Line& b : lines)
            for (const Line& a : lines) {
                out.normals.push_back((axis + a.lean * u + b.lean * v).normalized());
                out.corners.push_back(kInner * axis + a.at * u + b.at * v + render::kRound * out.normals.back());
            }
        for (std::uint32_t y = 0; y + 1 < side_length; ++y)
            for (std::uint32_t x = 0; x + 1 < side_length; ++x) {
                const std::uint32_t at = first + y * side_length + x, above = at + side_length;
                out.faces.insert(out.faces.end(), {{at, at + 1, above + 1}, {at, above + 1, above}});
            }
    }
    return out;
}

void add(Solid& solid, const Shape& shape, const Vec& at, float diameter, Rgb colour) {
    const auto first = static_cast<std::uint32_t>(solid.places.size());
    for (const Vec& corner : shape.corners) solid.places.emplace_back(at + diameter * corner);
    solid.normals.insert(solid.normals.end(), shape.normals.begin(), shape.normals.end());
    solid.colours.insert(solid.colours.end(), shape.corners.size(), colour);
    for (const auto& [a, b, c] : shape.faces) solid.faces.push_back({first + a, first + b, first + c});
}

// The catoms that can be seen from outside; all, unless those that touch others fill space.
std::vector<std::size_t> exposed(const render::Scene& scene) {
    const bool round = scene.form == Form::Rounded, fills = round || scene.form == Form::Sphere;
    const std::optional<render::Cells> cells = scene.diameters.empty() && fills
                                                   ? render::Cells::of(scene, round ? std::span<const Vec>(render::kAxes) : scene.ways)
                                                   : std::nullopt;
    const std::vector<std::uint8_t> depths = cells ? cells->depths(1) : std::vector<std::uint8_t>(scene.places.size());
    std::vector<std::size_t> out;
    for (std::size_t i = 0; i < depths.size(); ++i)
        if (depths[i] == 0) out.push_back(i);
    return out;
}

Solid cubes(const render::Scene& scene) {
    Solid out;
    const std::optional<render::Cells> cells = scene.diameters.empty() ? render::Cells::of(scene, render::kAxes) : std::nullopt;
    for (std::size_t way = 0; way < render::kAxes.size(); ++way) {
        const Shape shape = side(render::kAxes[way]);
        for (std::size_t i = 0; i < scene.places.size(); ++i)
            if (!cells || !cells->has_next(i, way)) add(out, shape, scene.places[i], scene.diameter(i), scene.colours[i]);
    }
    return out;
}

// A cylinder with round rims, turned: circles around its axis from the middle of one cap to that of the other.
Shape cylinder_of(const render::RoundedBody& body, std::size_t how_many) {
    // How far out in the core a circle is, how much its normal leans from the axis in degrees, and which cap it belongs to.
    struct Circle {
        float out, lean, end;
    };
    constexpr std::array<Circle, 8> kCircles = {
        {{0, 0, 1}, {1, 0, 1}, {1, 45, 1}, {1, 90, 1}, {1, 90, -1}, {1, 135, -1}, {1, 180, -1}, {0, 180, -1}}};
    const std::uint32_t sides = how_many <= kFew ? 48 : how_many <= kMany ? 24 : 12;
    Shape out;
    for (const auto& [wide, lean, end] : kCircles)
        for (std::uint32_t i = 0; i < sides; ++i) {
            const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(sides);
            const float down = lean * std::numbers::pi_v<float> / 180;
            const Vec around(std::cos(angle), std::sin(angle), 0), normal = std::sin(down) * around + std::cos(down) * Vec::UnitZ();
            out.normals.push_back(body.turn * normal);
            out.corners.push_back(body.turn *
                                  Vec(wide * body.core.x() * around + end * body.core.z() * Vec::UnitZ() + body.rounding * normal));
        }
    for (std::uint32_t circle = 0; circle + 1 < kCircles.size(); ++circle)
        for (std::uint32_t i = 0; i < sides; ++i) {
            const std::uint32_t at = circle * sides + i, next = circle * sides + (i + 1) % sides, below = at + sides, after = next + sides;
            if (kCircles[circle].out > 0) out.faces.push_back({at, after, next});
            if (kCircles[circle + 1].out > 0) out.faces.push_back({at, below, after});
        }
    return out;
}

// A box or a line with round edges, turned: on each side a grid as on a rounded cube.
Shape skin_of(const render::RoundedBody& body, std::size_t how_many) {
    if (body.is_cylinder()) return cylinder_of(body, how_many);
    // How much normals lean at grid lines: tangents of shares of 45 degrees.
    std::vector<float> leans = {0, 0.41421356F, 1};
    if (how_many <= kFew) leans = {0, 0.19891237F, 0.41421356F, 0.66817864F, 1};
    // A line, and to which end of the core it belongs.
    std::vector<std::pair<float, float>> lines;
    for (auto lean = leans.rbegin(); lean != leans.rend(); ++lean) lines.emplace_back(-*lean, -1.0F);
    for (const float lean : leans) lines.emplace_back(lean, 1.0F);
    const auto count = static_cast<std::uint32_t>(lines.size());
    Shape out;
    for (const Vec& axis : render::kAxes) {
        const Vec u(axis.y(), axis.z(), axis.x()), v = axis.cross(u);
        const auto first = static_cast<std::uint32_t>(out.corners.size());
        for (const auto& [b_lean, b_end] : lines)
            for (const auto& [a_lean, a_end] : lines) {
                const Vec normal = (axis + a_lean * u + b_lean * v).normalized(), end = axis + a_end * u + b_end * v;
                out.normals.push_back(body.turn * normal);
                out.corners.push_back(body.turn * Vec(end.cwiseProduct(body.core) + body.rounding * normal));
            }
        for (std::uint32_t y = 0; y + 1 < count; ++y)
            for (std::uint32_t x = 0; x + 1 < count; ++x) {
                const std::uint32_t at = first + y * count + x, above = at + count;
                out.faces.insert(out.faces.end(), {{at, at + 1, above + 1}, {at, above + 1, above}});
            }
    }
    return out;
}

}  // namespace

Solid solid_of(const render::Scene& scene) {
    if (!scene.rounded.empty()) {
        Solid out;
        for (std::size_t i = 0; i < scene.places.size(); ++i)
            scene.each_solid(i, [&](const Vec& middle, const render::RoundedBody& body) {
                add(out, skin_of(body, scene.places.size()), middle, 1, scene.colours[i]);
            });
        return out;
    }
    if (scene.form == Form::Cube) return cubes(scene);
    const std::vector<std::size_t> seen = exposed(scene);
    Solid out{.flat = scene.form == Form::Disc || scene.form == Form::Hexagon};
    const Shape shape = scene.form == Form::Sphere    ? ball(seen.size())
                        : scene.form == Form::Rounded ? rounded(seen.size())
                        : scene.form == Form::Hexagon ? polygon(6, std::numbers::inv_sqrt3_v<float>)
                                                      : polygon(24, 0.5F);
    for (const std::size_t i : seen) add(out, shape, scene.places[i], scene.diameter(i), scene.colours[i]);
    return out;
}

}  // namespace meld::picture
