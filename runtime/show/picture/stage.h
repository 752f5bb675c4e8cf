// What of a frame is seen without a question: catoms where they are, what they have drawn, and what stands around them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "runtime/results/record/drawing.h"
#include "runtime/show/picture/frame.h"
#include "runtime/show/render/scene.h"
#include "runtime/world/description/world.h"
#include "runtime/world/lattice/lattice.h"

namespace meld::picture {

render::Vec vec_of(const world::Vec3& at);
render::RoundedBody rounded_of(const world::RoundedBody& body);
// The compounds of a world, in the order of their numbers.
std::vector<std::vector<render::CompoundSolid>> compounds_of(const world::World& world);

// Puts catoms into a frame. The functions come in the order in which they stand here, and others may add to the scene between them.
class Stage {
  public:
    // `free`: catoms are at any place, and not on a lattice. What it gets must outlive it.
    Stage(const record::Drawn& drawn, const world::World& world, bool free, std::int64_t tick, const Look& look);

    // Puts those that are shown, by their places in what is drawn, into the scene.
    void show(const std::vector<bool>& shown);
    // Where in the scene the catom of this number is; nothing if it is not shown.
    std::optional<std::size_t> place(std::uint64_t id) const;
    // What catoms have drawn themselves: labels and lines; and of amoebots with two cells, a bar from the head to the tail.
    void add_drawn();
    // A callout of a catom by its number.
    void call_out(const Callout& callout);
    // Lines go between the middles of catoms, where nobody would see them: catoms get smaller, or the lines go above them.
    void uncover_lines();
    // The floor, the obstacles, the lamps that stand somewhere, and the joints between catoms that are shown.
    void surround();

    Frame frame = {};

  private:
    const record::Drawn& drawn_;
    const world::World& world_;
    const Look& look_;
    const bool in_plane_;
    std::vector<std::ptrdiff_t> places_ = {};  // Of catoms in the scene, as in drawn_; -1: not shown.
};

}  // namespace meld::picture
