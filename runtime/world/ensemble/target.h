// The cells of a world's target: all cells of its shape, a given number of them, or those of the shape scaled to fit.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/world/description/populate.h"
#include "runtime/world/description/world.h"
#include "runtime/world/ensemble/brick_table.h"
#include "runtime/world/lattice/lattice.h"

namespace meld::world {

// Immutable; any thread may use it.
class Target {
  public:
    // With `fit` in [target] the shape is first scaled until it contains as many cells as there is mass (fit.h). Without `fit` and `cells`
    // this costs nothing. With one of them, the cells are chosen here: breadth first over the lattice, from the target cell inside the body
    // that is nearest to the origin (ties by key), each distance in the order of keys, until the number is reached; so the choice is
    // connected and the same on every process. Cost: a few hundred nanoseconds per chosen cell. Errors: no catom is in the target; the
    // shape contains fewer cells than required.
    static Result<Target> make(const World& world, const Lattice& lattice);

    bool contains(Cell cell) const;
    // Sets the bits of the target's cells in a brick; the bits must be clear.
    void fill(Cell brick, std::span<std::uint64_t, 8> bits) const;
    // How many cells were chosen; absent if the target is the whole shape or there is none.
    std::optional<std::uint64_t> cells() const { return cells_; }
    // The shape of the target as a text, scaled if it was made to fit; empty if there is no target.
    std::string text() const { return shape_ ? shape_->text() : ""; }

  private:
    explicit Target(const Lattice& lattice) : lattice_(lattice) {}

    Lattice lattice_;
    std::optional<Shape> shape_;
    std::optional<std::uint64_t> cells_;
    // If cells were chosen: from bricks to rows of `chosen_`; row 0 is empty.
    BrickTable rows_;
    std::vector<BrickCells> chosen_ = {BrickCells{}};
};

}  // namespace meld::world
