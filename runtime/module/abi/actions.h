// The actions that the runtime knows, as the table actions.def describes them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace meld {

enum class ActionKind : std::uint8_t {
    None,  // An action that only the program declares.
#define MELD_ACTION(kind, word, arguments, performer, traits, failure) kind,
#include "runtime/module/abi/actions.def"
};

// The table's entry for an action; actions.def explains each column.
struct ActionInfo {
    enum class Performer { None, Lattice, Amoebots, Bodies, Points, Recording, Watcher, Printer, Clock, Run };
    enum Trait : unsigned { kCreates = 1, kTeleports = 2, kEndsRun = 4, kByTable = 8 };

    ActionKind kind = ActionKind::None;
    std::string_view word;
    std::size_t arguments = 0;
    Performer performer = Performer::None;
    unsigned traits = 0;
    std::int64_t failure = 0;

    bool has(Trait trait) const { return (traits & trait) != 0; }
};
// Valid for None too, which nobody carries out.
const ActionInfo& info(ActionKind kind);
// The word of the table for an action that a program writes with another word, `setColor` for `setcolor`; empty if there is none.
std::string_view standard_word(std::string_view alias);
// All but None, in the order of the table.
std::span<const ActionInfo> known_actions();

}  // namespace meld
