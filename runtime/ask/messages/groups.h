// How the facts of a module's predicates fall into groups, of which each has one value: as its rules keep them.
#pragma once

#include <vector>

#include "runtime/base/error.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::inspect {

struct Group {
    u16 arguments = 0;      // So many after the catom name it; the rest is its value.
    bool has_value = true;  // Otherwise the rest says since when it holds, which is not told again.
};

// Of each predicate that neighbours read, by its number in the module; of others nothing is said. The module does not say it, so the
// program that it carries is planned once more. Errors: the module carries no sources, or was made of them in another way. Cost: that of
// the compiler without C++, some milliseconds.
Result<std::vector<Group>> groups_of(const ModuleInfo& module);

}  // namespace meld::inspect
