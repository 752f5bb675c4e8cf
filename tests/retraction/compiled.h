// A program of this folder, compiled by meldc.
#pragma once

#include <string>

#include "runtime/module/abi/module_abi.h"
#include "runtime/module/load/module.h"

namespace meld::retraction {

// Errors: meldc says no, or the module is refused. Options are meldc's.
Result<Module> compiled(const std::string& name, const std::string& options = "");
inline const ModuleInfo& info_of(const Module& module) { return *static_cast<const ModuleInfo*>(module.table()); }

}  // namespace meld::retraction
