// Whether two programs are the same but for names, comments, layout, and the order of rules and of the parts of bodies.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "compiler/syntax/tree.h"

namespace meld::driver {

// The names that the items of a program declare: those that its author could have chosen otherwise.
std::set<std::string> declared_names(const syntax::Tree& tree);

// A hash that is the same for such programs, and different for others, up to chance. `fixed` are names that no author may choose, such as
// those that an exercise declares. Names are told apart by where they stand, in some rounds, as colour refinement tells the nodes of a
// graph apart: B. Weisfeiler, A. Leman, "The reduction of a graph to canonical form", 1968. Cost: linear in the text, for each round.
std::uint64_t likeness(const std::vector<syntax::Tree>& files, const std::set<std::string>& fixed);

}  // namespace meld::driver
