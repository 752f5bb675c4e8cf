// Outputs that a run has begun to write and not finished.
#pragma once

#include <set>
#include <string>

namespace meld {

// The files in the folder of `target` that hold a part of it, under names of their own (output_file.h), from this run or from runs that
// were killed. Cost: one listing of the folder.
std::set<std::string> partial_outputs_of(const std::string& target);

}  // namespace meld
