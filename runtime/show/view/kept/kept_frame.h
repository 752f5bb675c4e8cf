// A frame of a run on a lattice that is kept from one picture to the next: where catoms are, and what they are coloured by. Only what has
// changed is looked at again.
//
// All processes have one, and each says what has changed of its catoms; process 0 has the frame. It is the one that picture::look_at() and
// thin() make, to the bit.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/results/record/drawing.h"
#include "runtime/show/picture/frame.h"
#include "runtime/show/render/caption.h"
#include "runtime/show/render/cell_bits.h"
#include "runtime/show/view/kept/cell_box.h"
#include "runtime/show/view/kept/changed_catoms.h"
#include "runtime/show/view/kept/kept_values.h"
#include "runtime/show/view/scene/thin.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::view {

class KeptFrame {
  public:
    // For pages that get at most `most` catoms. Nothing: such a frame is not kept. These are frames of bodies, graphs, amoebots, and catoms
    // that draw more than colours; with lines or labels, of exposed catoms alone, and with bodies that may say something else of a catom
    // although nothing has changed there. The same on every process. The look outlives it.
    static std::unique_ptr<KeptFrame> make(const sim::Subdomain& subdomain, const record::Drawing& drawing, const picture::Look& look,
                                           std::size_t most);

    enum class Updated { Same, Other, TooWide };
    // Takes what has changed since the last call; every process calls it, between two ticks. Returns on process 0 whether anything is to be
    // seen of that, apart from the tick; and on all that catoms are so far apart, or were so many before, that it is not kept any longer.
    // Errors: a signal has asked for the end, and then it is not kept either. Cost: the bodies of the look at each catom that was touched;
    // if catoms have moved, come or gone, also a look at the cell of each, and the balls anew.
    Result<Updated> update(sim::Subdomain& subdomain, record::Drawing& drawing, sim::Touched& touched);

    // The rest on process 0, after update(). The frame in its colours, without those that nobody can see; and how many are shown with them.
    struct Seen {
        picture::Frame frame = {};
        std::optional<render::Legend> legend = {};
        std::size_t shown = 0;
    };
    // Cost: those that can be seen; and the values of chunks of 4,096 catoms in which one has changed.
    Seen seen(std::int64_t tick);
    // What thin() does, for that frame.
    Thinned thin(picture::Frame& frame) const;

  private:
    KeptFrame(const picture::Look& look, std::size_t most, const world::World& world, ChangedCatoms changed);
    bool agree(const sim::Subdomain& subdomain);
    Result<void> exchange(sim::Subdomain& subdomain, sim::Touched& touched);
    void renumber(const CellBox& before);
    void hide(std::uint64_t id);
    void show(const ShownCatoms& some);
    void choose();
    std::vector<std::uint32_t> all_shown() const;
    std::vector<std::uint32_t> unhidden() const;
    void place(const std::vector<std::uint32_t>& ids);

    const picture::Look& look_;
    std::size_t most_;
    const world::World& world_;
    world::Lattice lattice_;
    ChangedCatoms changed_;
    CellBox box_;
    CellBox::Bounds own_;     // Of the bricks of this process.
    std::size_t bricks_ = 0;  // That are in it.
    std::uint64_t next_id_ = 0;
    std::size_t catoms_ = 0;  // Of all processes, also those that are not shown.

    // On process 0.
    std::vector<std::uint32_t> cells_;  // By the number of a catom: that of its cell; kNowhere: it is not shown.
    std::vector<std::uint32_t> taken_;  // Cells to which catoms have come, while others may still have to leave them.
    render::CellBits occupied_;
    std::size_t shown_ = 0;
    KeptValues values_;
    bool moved_ = true, other_values_ = true;
    std::uint64_t colours_ = 0;  // Drawing::changes() that base_ has.
    picture::Frame base_;        // Of those that can be seen; values are not in it.
    std::vector<Cover> covers_;  // As of Thinned.
    std::optional<Balls> balls_;
};

}  // namespace meld::view
