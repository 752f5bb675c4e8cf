// Shapes as expressions, "minus(box(100,100,40), cylinder(r=20,h=50))", and regions that pick catoms.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/world/lattice/lattice.h"

namespace meld::world {

struct Box {
    Vec3 low, high;
    bool empty() const { return !(low[0] <= high[0] && low[1] <= high[1] && low[2] <= high[2]); }
};

// A solid in space, lengths in catom diameters. Cheap to copy (it shares an immutable tree); any thread may use it.
//
// Solids, centred on the origin, those with an axis along z; arguments by position or by name, cylinder(r=20, h=50):
//   box(x, y, z)  sphere(r)  ellipsoid(a, b, c)  cylinder(r, h)  cone(r1, r2, h): r1 at the bottom, r2 at the top
//   torus(R, r): a tube of radius r around a circle of radius R in the plane z = 0
//   helix(r, pitch, turns, thickness): a tube `thickness` wide around a coil that passes (r, 0, 0), its ends cut flat
//   gyroid(size, thickness, period = size / 2): a cube of a sheet that divides space into two labyrinths
//   trumpet(length, bell = length / 3, wall = 2): a horn along x: its stem begins at the origin, its rim is at x = length
//   campus(size): a made-up group of buildings `size` long in x, standing on the plane z = 0 around the origin
//   mesh('part.stl', size) or mesh('part.stl', scale = f): a model from a file (docs/reference/worlds.md)
// Combinations: union(s, ...)  intersect(s, ...)  minus(s, t, ...): s without t, ...
//   shell(s, thickness): the points of s nearer than that to its surface
//   move(s, x, y, z = 0)  rotate(s, axis, degrees): about x, y or z, right-handed  scale(s, f): about the origin
// Flat faces are half open, low <= p < high: box(n, n, n) on a cubic lattice is n^3 cells. Cell (0,0,0) is at the origin.
class Shape {
  public:
    struct Node;
    Shape() = default;                                    // Holds nothing.
    static Result<Shape> parse(const std::string& text);  // Without models. Errors: column, what was expected, nearest shape name.
    explicit Shape(std::shared_ptr<const Node> root) : root_(std::move(root)) {}
    const Node* root() const { return root_.get(); }
    static Shape unite(std::vector<Shape> shapes);
    bool contains(const Vec3& point) const;
    Box bounds() const;
    // Whether the whole box certainly lies in the shape; false if in doubt.
    bool surely_contains(const Box& box) const;
    // Whether the box may contain a point of the shape; false only if it certainly does not. For skipping whole bricks.
    bool may_touch(const Box& box) const;
    std::string text() const;

  private:
    std::shared_ptr<const Node> root_;
};

// The catoms that get a given fact: "id == 4", "cell == (0,0,0)", "all", "id < 10", "x > 3 && z == 0", "inside(sphere(r=4))", combined with
// && || ! and parentheses. x, y and z are coordinates of the cell; inside() tests its centre. "id % 2 == 0" and the like select every n-th.
// In a world with robots also "part == left", "robot == 3" and "assembly == walker".
class Region {
  public:
    struct Node;
    Region() = default;  // All catoms.
    static Result<Region> parse(const std::string& text);
    bool contains(std::uint64_t id, Cell cell, const Vec3& position) const;
    const std::string& text() const { return text_; }
    Region(std::shared_ptr<const Node> root, std::string text) : root_(std::move(root)), text_(std::move(text)) {}

  private:
    std::shared_ptr<const Node> root_;
    std::string text_ = "all";
};

}  // namespace meld::world
