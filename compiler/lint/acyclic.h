// Recursion along the links of a graph that has no circle.
#pragma once

#include "compiler/check/program/program.h"

namespace meld::lint {

// Whether the recursion ends because each turn of it follows facts of `link` in one direction, there where these lead in no circle: as
// those that the world gives. Facts of `link` that the program makes itself are not the world's.
bool ends_with_links(const check::Program& program, const check::Stratum& stratum);

}  // namespace meld::lint
