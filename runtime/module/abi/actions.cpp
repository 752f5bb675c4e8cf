#include "runtime/module/abi/actions.h"

#include <iterator>

#include "runtime/base/assert.h"

namespace meld {

namespace {

using Performer = ActionInfo::Performer;
constexpr unsigned kCreates = ActionInfo::kCreates, kTeleports = ActionInfo::kTeleports, kEndsRun = ActionInfo::kEndsRun,
                   kByTable = ActionInfo::kByTable;

constexpr ActionInfo kActions[] = {
    {},
#define MELD_ACTION(kind, word, arguments, performer, traits, failure) \
    {ActionKind::kind, word, arguments, Performer::performer, traits, failure},
#include "runtime/module/abi/actions.def"
};

}  // namespace

const ActionInfo& info(ActionKind kind) {
    const auto index = static_cast<std::size_t>(kind);
    MELD_EXPECT(index < std::size(kActions), "action {}", index);
    return kActions[index];
}

std::string_view standard_word(std::string_view alias) {
#define MELD_ACTION(kind, word, arguments, performer, traits, failure)
#define MELD_ACTION_ALIAS(other, word) \
    if (alias == other) return word;
#include "runtime/module/abi/actions.def"
    return {};
}

std::span<const ActionInfo> known_actions() { return std::span(kActions).subspan(1); }

}  // namespace meld
