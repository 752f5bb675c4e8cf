// The catoms one part knows: which cell each stands on, which catom stands on each cell, in bricks.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "runtime/abi/geometry_abi.h"
#include "runtime/world/lattice.h"

namespace meld::world {

using Slot = std::uint32_t;
using Catom = std::uint32_t;  // An index on this part, not an id.

class Ensemble {
  public:
    // in_target says for a cell whether it is in the target shape; asked once per cell of a brick when the brick is made.
    Ensemble(const Lattice& lattice, std::function<bool(Cell)> in_target);

    const Lattice& lattice() const { return lattice_; }
    // The arrays a module reads. Pointers change when catoms or bricks are added: fetch again after any change.
    Geometry geometry() const;

    // The slot of a brick, made empty if it is not there yet. Cost: a hash lookup, cached for repeated bricks.
    Slot slot(Cell brick);
    std::optional<Slot> find_slot(Cell brick) const;
    Cell brick(Slot slot) const;
    std::size_t brick_count() const;  // Without the empty slot 0.
    // Makes all 26 neighbours of a brick present, so that every cell a catom there can reach has a slot.
    void surround(Slot slot);

    // Adds a catom on an empty cell and returns its index, the lowest free one, else a new one at the end.
    Catom add(std::uint64_t id, Cell cell, CatomState state);
    void remove(Catom catom);
    // Moves a catom to an empty cell.
    void move(Catom catom, Cell to);
    void set_state(Catom catom, CatomState state);

    std::optional<Catom> at(Cell cell) const;
    Cell cell(Catom catom) const;
    std::uint64_t id(Catom catom) const { return id_[catom]; }
    CatomState state(Catom catom) const { return static_cast<CatomState>(state_[catom]); }
    bool target(Cell cell) const;  // False also where no brick is present.
    Vec3 position(Catom catom) const { return lattice_.position(cell(catom)); }

    std::size_t index_count() const { return id_.size(); }
    std::size_t owned_count() const { return owned_count_; }
    std::size_t ghost_count() const { return ghost_count_; }
    // The catom with this id, if this part knows it. Cost: one hash lookup; the map is made on first use and kept.
    std::optional<Catom> find(std::uint64_t id) const;
    void reserve(std::size_t catoms, std::size_t bricks);
    std::size_t bytes() const;

  private:
    // (the implementer fills this in)
    const Lattice lattice_;
    std::function<bool(Cell)> in_target_;
    std::vector<std::uint64_t> id_;
    std::vector<std::uint8_t> state_;
    std::size_t owned_count_ = 0, ghost_count_ = 0;
};

}  // namespace meld::world
