// The predicates of a program that are actions known to the runtime, found by name once, when the module is loaded.
#pragma once

#include <optional>
#include <vector>

#include "runtime/module/abi/actions.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::tuple {

class ProgramActions {
  public:
    explicit ProgramActions(const ModuleInfo& module);

    ActionKind kind_of(u32 predicate) const { return kinds_[predicate]; }
    // The predicate of an action, if the program uses it.
    std::optional<u32> predicate_of(ActionKind kind) const;
    bool uses(ActionKind kind) const { return predicate_of(kind).has_value(); }

  private:
    std::vector<ActionKind> kinds_;  // By predicate.
};

}  // namespace meld::tuple
