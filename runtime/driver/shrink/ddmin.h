// Delta debugging: a small part of a list that still has a property, such as that a run fails.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "runtime/base/error.h"

namespace meld::driver {

// Numbers of items of a list, ascending.
using Kept = std::vector<std::size_t>;
// Tries so many candidates: the first, in their order, that has the property; nothing if none has. Each is made when it is tried.
using TryFirst = std::function<Result<std::optional<std::size_t>>(std::size_t count, const std::function<Kept(std::size_t)>& candidate)>;

// The items that are left of a list of this many when no single one of them can be taken away any more (ddmin of A. Zeller and
// R. Hildebrandt, "Simplifying and isolating failure-inducing input", IEEE TSE 28(2), 2002, section 3). Two changes leave that as it is:
// parts are not tried alone (R. Hodovan and A. Kiss, "Practical improvements to the minimizing delta debugging algorithm", 2016), and the
// search goes on where it has taken something away, from the end of the list to its beginning. Cost: at best some log2(items) tries for
// each item that is left, at worst their square.
Result<Kept> ddmin(std::size_t items, const TryFirst& try_first);

}  // namespace meld::driver
