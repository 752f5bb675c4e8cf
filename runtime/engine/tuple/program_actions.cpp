#include "runtime/engine/tuple/program_actions.h"

#include <algorithm>

#include "runtime/base/assert.h"
#include "runtime/engine/tuple/facts.h"

namespace meld::tuple {

ProgramActions::ProgramActions(const ModuleInfo& module) : kinds_(module.predicate_count, ActionKind::None) {
    for (const ActionInfo& action : known_actions())
        if (const std::optional<u32> predicate = find_action(module, action.word, action.arguments)) {
            MELD_ASSERT(kinds_[*predicate] == ActionKind::None, "{} is two actions", action.word);
            kinds_[*predicate] = action.kind;
        }
}

std::optional<u32> ProgramActions::predicate_of(ActionKind kind) const {
    MELD_EXPECT(kind != ActionKind::None, "there are many actions that the runtime does not know");
    const auto found = std::find(kinds_.begin(), kinds_.end(), kind);
    return found == kinds_.end() ? std::nullopt : std::optional(static_cast<u32>(found - kinds_.begin()));
}

}  // namespace meld::tuple
