// What catoms have drawn so far, for pictures of a run that is not recorded: a SimModule that follows it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/results/record/appearance.h"
#include "runtime/sim/core/extension.h"
#include "runtime/sim/core/subdomain.h"
#include "runtime/world/lattice/lattice.h"
#include "runtime/world/shapes/joint_look.h"

namespace meld::record {

// The array of where the other cells of amoebots are: /VTKHDF/PointData/tail_position.
inline constexpr const char* kTailPosition = "tail_position";

// The arrays of what bodies look like that are no spheres: half the edges of their cores in diameters and the rounding; and the rotations
// as w, x, y, z.
inline constexpr const char* kCore = "core";
inline constexpr const char* kOrientation = "orientation";
// The same of spheres, where joints hold some; no predicate has this name.
inline constexpr const char* kTurns = "joint.orientation";

// All catoms of a run as they are drawn, in the order of their numbers.
struct Drawn {
    std::vector<u64> ids = {};
    std::vector<world::Vec3> positions = {};       // In catom diameters.
    std::vector<double> diameters = {};            // Empty where bodies do not differ in size.
    std::vector<world::RoundedBody> rounded = {};  // Empty where all are spheres.
    // How bodies are turned, as w, x, y, z; empty where that is not known, or `rounded` says it.
    std::vector<std::array<double, 4>> turns = {};
    std::vector<world::JointLook> joints = {};  // That hold now.
    std::vector<world::Vec3> tails = {};        // Where an amoebot's other cell is, or its only one; empty if there are no amoebots.
    std::vector<std::uint32_t> colours = {};    // 0xRRGGBB.
    std::vector<std::string> labels = {};       // Empty if the program sets none.
    std::vector<std::pair<std::size_t, std::size_t>> lines = {};  // Between catoms, by their places here.

    // Where a catom stands; nothing if there is none of this number.
    std::optional<std::size_t> find(u64 id) const;
    // How the catom at a place is turned.
    std::array<double, 4> turn(std::size_t at) const;
};

// Where an amoebot's tail is; of any other catom, and of an amoebot with one cell, where it is itself.
world::Vec3 tail_position(const sim::Subdomain& subdomain, sim::Catom catom);

class Drawing : public sim::SimModule {
  public:
    Result<void> start(sim::Subdomain& subdomain) override;
    Result<void> after(sim::Subdomain& subdomain) override;
    Result<void> saveable() const override { return {}; }
    // It loads what a recorder has kept, since both keep that first.
    void save_rest(const sim::Subdomain& subdomain, ByteWriter& out) const override;
    Result<void> load_rest(sim::Subdomain& subdomain, ByteReader& in) override;

    // Of all processes, on process 0; the others get nothing. Every process calls it, between two ticks.
    Drawn drawn(sim::Subdomain& subdomain);

    // Whether catoms have places, colours and nothing else: what only bodies and amoebots have, and labels and lines, which the program has
    // an action for, make a picture of more.
    bool draws_cells_only(const sim::Subdomain& subdomain) const;
    // Process 0 learns what catoms have drawn since the last call of this or of drawn(). Every process calls it, between two ticks. Cost:
    // that.
    void catch_up(sim::Subdomain& subdomain);
    // On process 0, after either: the colour of a catom, 0xRRGGBB; and a number that is another one when some have changed.
    std::uint32_t colour(u64 id) const { return appearance_.colour(id); }
    std::uint64_t changes() const { return appearance_.changes(); }

  private:
    struct DrawnRow {
        u64 id;
        world::Vec3 position, tail;
        double diameter;
        world::RoundedBody rounded;
    };
    static DrawnRow row_of(const sim::Subdomain& subdomain, sim::Catom catom);
    void begin(const sim::Subdomain& subdomain, std::size_t most, Drawn& drawn);
    void add(const sim::Subdomain& subdomain, const DrawnRow& row, Drawn& drawn) const;
    void draw_own(const sim::Subdomain& subdomain, Drawn& drawn);
    void draw_all(sim::Subdomain& subdomain, Drawn& drawn);

    Appearance appearance_;
};

}  // namespace meld::record
