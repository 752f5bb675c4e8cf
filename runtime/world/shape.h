// Shapes as expressions, "minus(box(100,100,40), cylinder(r=20,h=50))", and regions that pick catoms.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/world/lattice.h"

namespace meld::world {

struct Box {
    Vec3 low, high;
    bool empty() const { return !(low[0] <= high[0] && low[1] <= high[1] && low[2] <= high[2]); }
};

// A solid in space, lengths in catom diameters. Cheap to copy (shared immutable tree is hidden inside).
class Shape {
  public:
    Shape();                                   // Holds nothing.
    static Result<Shape> parse(const std::string& text);  // Errors: column, what was expected, nearest shape name.
    static Shape unite(std::vector<Shape> shapes);
    bool contains(const Vec3& point) const;
    Box bounds() const;
    // Whether the box may hold a point of the shape; false only when surely not. For skipping whole bricks.
    bool may_touch(const Box& box) const;
    std::string text() const;
    struct Node;

  private:
    std::shared_ptr<const Node> root_;
};

// Which catoms a given fact is for: "id == 4", "cell == (0,0,0)", "all", "id < 10", "x > 3 && z == 0",
// "inside(sphere(r=4))", combined with && || and parentheses.
class Region {
  public:
    Region();                                  // All catoms.
    static Result<Region> parse(const std::string& text);
    bool contains(std::uint64_t id, Cell cell, const Vec3& position) const;
    const std::string& text() const { return text_; }
    struct Node;

  private:
    std::shared_ptr<const Node> root_;
    std::string text_;
};

}  // namespace meld::world
