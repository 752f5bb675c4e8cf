// The set-up of a subdomain: catoms and ghosts from the world, ids along the curve, the program's parameters, the world's facts.
#pragma once

#include <optional>
#include <string>

#include "runtime/base/error.h"
#include "runtime/sim/catoms/brick_counts.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

class Setup {
  public:
    explicit Setup(Subdomain& subdomain) : subdomain_(subdomain) {}
    // With what has been counted before, if anything was.
    Result<void> run(std::optional<BrickCounts> counted);

    // ---- what a run that goes on from a snapshot needs too
    // Says who owns which bricks, and who sees which cells.
    void divide(const BrickCounts& counts);
    // How many cells from its own a catom sees.
    static int reach(const world::World& world, const tuple::ProgramActions& actions);
    // Whether catoms see cells in bricks without catoms; then those around each brick are there too.
    static bool looks_around(const world::World& world);
    // How many bricks there is room for at first, if so many have catoms.
    static std::size_t room_for_bricks(std::size_t bricks) { return bricks + bricks / 2 + 32; }
    // Makes the bricks present that catoms here can reach or see.
    void surround();
    // The limits of the world and the constants of the program. Errors: a constant is missing, unknown or of another type.
    Result<void> set_constants();

  private:
    void populate_cells(const BrickCounts& counts);
    void populate_freely(const BrickCounts& counts);
    // Those whose first evaluation may do something are awake in the first tick.
    void mark_births();
    // The single links of the network must be those of catoms.
    Result<void> check_single_links() const;
    void set_limits();
    Result<void> set_parameters();

    Subdomain& subdomain_;
};

// An error if a list was refused since the last call, because it is longer than the world allows. `what` contained it.
Result<void> check_length(tuple::ListStore& lists, const SubdomainView& limits, const std::string& what);

}  // namespace meld::sim
