// The size of a world before it is made.
#pragma once

#include "runtime/base/error.h"
#include "runtime/world/description/world.h"

namespace meld::world {

// The number of catoms of the world and the box of cells that contains them, without making them. Used for memory estimates before anything
// is allocated; exact for one box and for listed cells. Otherwise space is divided into some ten thousand pieces, and those that the shape
// does not reach are left out. The upper bound counts the rest as full, which is far too much for a large thin shell; the estimate tests a
// few cells in each and is right to a percent or two. Cost: some milliseconds, however large the world. Errors: the body is empty; it
// reaches beyond the cells that exist.
struct WorldSize {
    double cells_upper_bound = 0;
    double cells_estimate = 0;
    Cell first, last;
};
Result<WorldSize> measure(const World& world);

}  // namespace meld::world
