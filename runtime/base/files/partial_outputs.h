// What runs have begun to write and not brought to its end.
#pragma once

#include <set>
#include <string>

namespace meld {

// The files beside a target that have been begun under names of their own (output_file.h), for it or by runs that were killed. Cost: a
// look at its folder.
std::set<std::string> begun_beside(const std::string& target);

}  // namespace meld
