// Fewer catoms for a page that shows very many: those that others hide are left out, and if that is not enough, balls stand for several.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/show/picture/frame.h"

namespace meld::view {

// What a catom's neighbours take of its sky, in parts of 127: half the sum of the ways to them and a quarter of their number, so scaled
// that a catom between others on all sides has 127 in the last.
using Cover = std::array<std::int8_t, 4>;

struct Thinned {
    std::vector<Cover> covers = {};  // Of the catoms that are left; empty: nothing was left out.
    int coarse = 1;                  // Each ball that is left stands for what is in a cube with sides of so many diameters.
};

// Of a frame whose catoms have their colours and are more than `most`: leaves out those on a lattice that nobody can see, and if they are
// still more, puts one ball, in their mean colour and with the number of the first, in the place of several. Labels and values go with
// their catoms; balls have no values. Cost: some 30 ns a catom.
Thinned thin(picture::Frame& frame, std::size_t most);

}  // namespace meld::view
