// The sense `possible(A, X, Y, Z)`: where the moves of the world lead that a catom can make now (docs/moves.md). Stored for programs that
// read it, and found anew where a cell has changed on which it depends.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/sim/core/subdomain.h"
#include "runtime/world/lattice/move_table.h"

namespace meld::sim {

class PossibleMoves {
  public:
    explicit PossibleMoves(const world::World& world) : table_(world.motion.moves.get()) {}
    // Finds the predicate, if the program reads it. Errors: it does, and the world names no moves.
    Result<void> start(const Subdomain& subdomain);
    // All catoms of this process sense what they can do now. Cost: nothing if the program does not read it.
    void sense(Subdomain& subdomain) const;
    // A catom has come to this cell, or left it, or has lost what it sensed.
    void note(Cell cell) {
        if (predicate_) changed_.push_back(cell);
    }
    // Those sense it that depend on a cell that was noted since the last call.
    void sense_changes(Subdomain& subdomain);

  private:
    // Memory that is used again for each catom.
    struct Scratch {
        std::vector<std::uint8_t> known;
        std::vector<Cell> last, now;
    };
    // Returns the dirty bits of what has changed.
    u64 sense_catom(Subdomain& subdomain, Catom catom, int worker, Scratch& scratch) const;
    void sense_all(Subdomain& subdomain, std::span<const Catom> catoms) const;

    const world::MoveTable* table_;  // Of the world; null: none.
    std::optional<u32> predicate_;
    u64 dirty_ = 0;
    std::vector<Cell> changed_;
};

// Errors: the program reads `possible`, which nothing in this world says anything of.
Result<void> check_nothing_possible(const Subdomain& subdomain);

}  // namespace meld::sim
