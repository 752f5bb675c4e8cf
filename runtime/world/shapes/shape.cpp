// Queries of a shape: each query walks down the tree and combines results by the rules of sets and of distances.
#include "runtime/world/shapes/shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "runtime/world/shapes/expression.h"
#include "runtime/world/shapes/shape_tree.h"

namespace meld::world {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Distances are rounded; a box this close to a surface counts as touched.
constexpr double kSlack = 1e-9;
constexpr Box kNothing = {{0, 0, 0}, {-1, -1, -1}};

double distance_of(const Shape& shape, const Vec3& p);

bool within(const Box& box, const Vec3& p) {
    return p[0] >= box.low[0] && p[0] <= box.high[0] && p[1] >= box.low[1] && p[1] <= box.high[1] && p[2] >= box.low[2] &&
           p[2] <= box.high[2];
}

Vec3 minus(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec3 times(const Vec3& a, double f) { return {a[0] * f, a[1] * f, a[2] * f}; }

Vec3 turned(const Vec3& p, std::size_t axis, double sine, double cosine) {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    Vec3 result = p;
    result[u] = cosine * p[u] - sine * p[v];
    result[v] = sine * p[u] + cosine * p[v];
    return result;
}
Vec3 turned_back(const Rotated& s, const Vec3& p) { return turned(p, s.axis, -s.sine, s.cosine); }

Vec3 in_model(const Modelled& s, const Vec3& p) {
    return {p[0] * s.units + s.centre[0], p[1] * s.units + s.centre[1], p[2] * s.units + s.centre[2]};
}

bool contains(const Modelled& s, const Vec3& p) { return s.solid->contains(in_model(s, p)); }
bool contains(const Union& s, const Vec3& p) {
    return std::any_of(s.parts.begin(), s.parts.end(), [&p](const Shape& part) { return part.contains(p); });
}
bool contains(const Intersection& s, const Vec3& p) {
    return std::all_of(s.parts.begin(), s.parts.end(), [&p](const Shape& part) { return part.contains(p); });
}
bool contains(const Difference& s, const Vec3& p) {
    return s.whole.contains(p) && std::none_of(s.without.begin(), s.without.end(), [&p](const Shape& part) { return part.contains(p); });
}
bool contains(const Shell& s, const Vec3& p) { return s.solid.contains(p) && distance_of(s.solid, p) > -s.thickness; }
bool contains(const Moved& s, const Vec3& p) { return s.solid.contains(minus(p, s.by)); }
bool contains(const Rotated& s, const Vec3& p) { return s.solid.contains(turned_back(s, p)); }
bool contains(const Scaled& s, const Vec3& p) { return s.solid.contains(times(p, 1 / s.factor)); }

bool holds(const Solid& solid, const Vec3& p) {
    return std::visit([&p](const auto& s) { return contains(s, p); }, solid);
}

// From a point to a box; 0 inside.
double distance_to(const Box& box, const Vec3& p) {
    double square = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const double outside = std::max({box.low[i] - p[i], p[i] - box.high[i], 0.0});
        square += outside * outside;
    }
    return std::sqrt(square);
}

double distance(const Modelled& s, const Vec3& p) { return s.solid->distance(in_model(s, p)) / s.units; }
// A part is asked only if its box is nearer than what is known; the nearer of two first.
double distance(const Union& s, const Vec3& p) {
    const auto box_of = [&p](const Shape& part) { return part.root() ? distance_to(part.root()->bounds, p) : kInfinity; };
    double least = kInfinity;
    const auto ask = [&](const Shape& part) {
        if (box_of(part) < least) least = std::min(least, distance_of(part, p));
    };
    const bool swapped = s.parts.size() == 2 && box_of(s.parts[1]) < box_of(s.parts[0]);
    if (swapped)
        std::for_each(s.parts.rbegin(), s.parts.rend(), ask);
    else
        std::for_each(s.parts.begin(), s.parts.end(), ask);
    return least;
}
double distance(const Intersection& s, const Vec3& p) {
    double most = -kInfinity;
    for (const Shape& part : s.parts) most = std::max(most, distance_of(part, p));
    return most;
}
double distance(const Difference& s, const Vec3& p) {
    double most = distance_of(s.whole, p);
    for (const Shape& part : s.without) most = std::max(most, -distance_of(part, p));
    return most;
}
double distance(const Shell& s, const Vec3& p) {
    const double solid = distance_of(s.solid, p);
    return std::max(solid, -s.thickness - solid);
}
double distance(const Moved& s, const Vec3& p) { return distance_of(s.solid, minus(p, s.by)); }
double distance(const Rotated& s, const Vec3& p) { return distance_of(s.solid, turned_back(s, p)); }
double distance(const Scaled& s, const Vec3& p) { return s.factor * distance_of(s.solid, times(p, 1 / s.factor)); }

double distance_of(const Shape& shape, const Vec3& p) {
    if (!shape.root()) return kInfinity;
    return std::visit([&p](const auto& solid) { return distance(solid, p); }, shape.root()->solid);
}

// A box a little larger: rounding must not exclude a point of the shape.
Box with_slack(Box box) {
    for (double& x : box.low) x -= kSlack * (1 + std::abs(x));
    for (double& x : box.high) x += kSlack * (1 + std::abs(x));
    return box;
}

Box bounds(const Modelled& s) {
    const auto in_world = [&s](const Vec3& p) { return times(minus(p, s.centre), 1 / s.units); };
    return with_slack({in_world(s.solid->low()), in_world(s.solid->high())});
}
Box bounds(const Union& s) {
    Box all = kNothing;
    for (const Shape& part : s.parts) {
        const Box box = part.bounds();
        if (box.empty()) continue;
        if (all.empty()) all = box;
        for (std::size_t i = 0; i < 3; ++i) {
            all.low[i] = std::min(all.low[i], box.low[i]);
            all.high[i] = std::max(all.high[i], box.high[i]);
        }
    }
    return all;
}
Box bounds(const Intersection& s) {
    Box all = {{-kInfinity, -kInfinity, -kInfinity}, {kInfinity, kInfinity, kInfinity}};
    for (const Shape& part : s.parts) {
        const Box box = part.bounds();
        for (std::size_t i = 0; i < 3; ++i) {
            all.low[i] = std::max(all.low[i], box.low[i]);
            all.high[i] = std::min(all.high[i], box.high[i]);
        }
    }
    return all.empty() ? kNothing : all;
}
Box bounds(const Difference& s) { return s.whole.bounds(); }
Box bounds(const Shell& s) { return s.solid.bounds(); }
Box bounds(const Moved& s) {
    const Box box = s.solid.bounds();
    return {minus(box.low, times(s.by, -1)), minus(box.high, times(s.by, -1))};
}
Box bounds(const Scaled& s) {
    const Box box = s.solid.bounds();
    return {times(box.low, s.factor), times(box.high, s.factor)};
}
Box bounds(const Rotated& s) {
    const Box box = s.solid.bounds();
    if (box.empty()) return kNothing;
    Box all = {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
    for (unsigned corner = 0; corner < 8; ++corner) {
        Vec3 p;
        for (std::size_t i = 0; i < 3; ++i) p[i] = corner >> i & 1 ? box.high[i] : box.low[i];
        p = turned(p, s.axis, s.sine, s.cosine);
        for (std::size_t i = 0; i < 3; ++i) {
            all.low[i] = std::min(all.low[i], p[i]);
            all.high[i] = std::max(all.high[i], p[i]);
        }
    }
    return with_slack(all);
}

// The middle of a box, and the distance of its corners from there, plus a little for rounding.
struct BallAround {
    Vec3 centre;
    double radius;
};
BallAround ball_around(const Box& box) {
    Vec3 centre;
    double square = 0, size = 1;
    for (std::size_t i = 0; i < 3; ++i) {
        centre[i] = std::midpoint(box.low[i], box.high[i]);
        square += (box.high[i] - centre[i]) * (box.high[i] - centre[i]);
        size += std::abs(box.high[i]) + std::abs(box.low[i]);
    }
    return {centre, std::sqrt(square) + kSlack * size};
}

// A union of many parts as a tree of unions that lie together, so that a question goes down a few branches alone.
Union in_groups(std::vector<Shape> parts) {
    constexpr std::size_t kFew = 4;
    std::erase_if(parts, [](const Shape& part) { return part.bounds().empty(); });
    if (parts.size() <= kFew) return {std::move(parts)};
    const auto middle = [](const Shape& part, std::size_t axis) { return part.bounds().low[axis] / 2 + part.bounds().high[axis] / 2; };
    std::size_t along = 0;
    double longest = -1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto [low, high] = std::minmax_element(parts.begin(), parts.end(),
                                                     [&](const Shape& a, const Shape& b) { return middle(a, axis) < middle(b, axis); });
        const double length = middle(*high, axis) - middle(*low, axis);
        if (length <= longest) continue;
        longest = length;
        along = axis;
    }
    std::stable_sort(parts.begin(), parts.end(), [&](const Shape& a, const Shape& b) { return middle(a, along) < middle(b, along); });
    const auto half = parts.begin() + static_cast<std::ptrdiff_t>(parts.size() / 2);
    std::vector<Shape> low(parts.begin(), half), high(half, parts.end());
    return {{make_shape(in_groups(std::move(low)), ""), make_shape(in_groups(std::move(high)), "")}};
}

bool is_open(const Shape& shape) { return shape.root() && shape.root()->open; }
bool any_open(const std::vector<Shape>& shapes) { return std::any_of(shapes.begin(), shapes.end(), is_open); }

// Whether a model with an open surface is in it.
struct FindOpen {
    bool operator()(const Modelled& s) const { return !s.solid->closed(); }
    bool operator()(const Union& s) const { return any_open(s.parts); }
    bool operator()(const Intersection& s) const { return any_open(s.parts); }
    bool operator()(const Difference& s) const { return is_open(s.whole) || any_open(s.without); }
    template <class Other>
    bool operator()(const Other& s) const {
        if constexpr (requires { s.solid; })
            return is_open(s.solid);
        else
            return false;
    }
};

}  // namespace

Vec3 turned(const Vec3& p, const Rotated& by) { return turned(p, by.axis, by.sine, by.cosine); }

Shape make_shape(Solid solid, std::string text) {
    if (auto* all = std::get_if<Union>(&solid)) *all = in_groups(std::move(all->parts));
    const Box box = std::visit([](const auto& s) { return bounds(s); }, solid);
    const bool open = std::visit(FindOpen{}, solid);
    return Shape(std::make_shared<const Shape::Node>(Shape::Node{std::move(solid), box, std::move(text), open}));
}

Result<Shape> Shape::parse(const std::string& text) {
    return parse_shape_text(text).map_error([](const ExpressionError& error) { return error.error(); });
}

Shape Shape::unite(std::vector<Shape> shapes) {
    std::erase_if(shapes, [](const Shape& shape) { return !shape.root(); });
    if (shapes.empty()) return Shape();
    if (shapes.size() == 1) return shapes[0];
    std::string text = "union(";
    for (const Shape& shape : shapes) text += (&shape == shapes.data() ? "" : ", ") + shape.text();
    return make_shape(Union{std::move(shapes)}, text + ")");
}

bool Shape::contains(const Vec3& point) const {
    if (!root_ || !within(root_->bounds, point)) return false;
    return holds(root_->solid, point);
}

Box Shape::bounds() const { return root_ ? root_->bounds : kNothing; }

bool Shape::may_touch(const Box& box) const {
    if (!root_ || box.empty()) return false;
    for (std::size_t i = 0; i < 3; ++i) {
        if (box.high[i] < root_->bounds.low[i] || box.low[i] > root_->bounds.high[i]) return false;
    }
    if (root_->open) return true;
    const BallAround ball = ball_around(box);
    return distance_of(*this, ball.centre) <= ball.radius;
}

bool Shape::surely_contains(const Box& box) const {
    if (!root_ || root_->open || box.empty()) return false;
    const BallAround ball = ball_around(box);
    return distance_of(*this, ball.centre) < -ball.radius;
}

std::string Shape::text() const { return root_ ? root_->text : "union()"; }

}  // namespace meld::world
