// A program's text through the compiler, in this process: what was checked, and the module.
#pragma once

#include <memory>
#include <string>

#include "compiler/check/program/program.h"
#include "runtime/module/abi/module_abi.h"
#include "runtime/module/load/module.h"

namespace meld::reference {

// Errors: what the compiler says against the program.
Result<check::Program> checked(const std::string& text);

// How Clang compiles modules. At -O0 it takes a sixth of the time, so most random programs are; what a user gets is the other.
enum class Level { Quick, Shipped };

// A folder for programs and modules that is removed in the end.
class Workshop {
  public:
    explicit Workshop(Level level = Level::Shipped);
    ~Workshop();
    Workshop(const Workshop&) = delete;
    Workshop& operator=(const Workshop&) = delete;

    // Errors: what the compiler says, or that the module is refused.
    Result<Module> module(const std::string& text, bool by_links = false);

    Level level;

  private:
    std::string folder_;
};
inline const ModuleInfo& info_of(const Module& module) { return *static_cast<const ModuleInfo*>(module.table()); }

}  // namespace meld::reference
