// The bodies of a run on several processes: each part holds those in its blocks of space and, as ghosts, those around. Carries
// the messages of physics/part.h; the bits are those of the undivided world.
#pragma once

#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "physics/part.h"
#include "runtime/partition/partition.h"
#include "runtime/sim/part_state.h"

namespace meld::sim {

class DividedBodies {
  public:
    // Divides space by where the bodies stand now, along a curve through the blocks, so that each part has about as many. Every
    // part calls it; the scene has this part's bodies, wherever they are.
    DividedBodies(PartState& part, physics::Scene& scene);

    // Before a step, on every part: whether bodies have changed hands. Those that were ours and are no more are in departed().
    Result<bool> redistribute(PartState& part, double step_s, int substeps);
    const std::vector<std::pair<physics::BodyId, int>>& departed() const { return bodies_->departed(); }
    // A step. The error of the first part that has one is everybody's.
    Result<physics::StepReport> step(PartState& part, double step_s, int substeps);
    int owner_of(physics::BodyId body) const { return bodies_->owner_of(body); }

  private:
    int owner(physics::BlockCoordinates block) const;

    // Blocks lie on the curve of a lattice's bricks, however the catoms began.
    world::Lattice curve_{world::LatticeKind::Cubic};
    std::optional<partition::Partition> partition_;
    mutable std::unordered_map<std::uint64_t, int> owners_;  // Of blocks that have been asked for.
    std::unique_ptr<physics::Part> bodies_;
};

// Gives all parts the bytes of all, in the order of parts; one part has its own.
std::vector<std::vector<std::byte>> gather_bytes(PartState& part, const std::vector<std::byte>& mine);
// Sends bytes to parts by number (none to itself), and returns what came, in the order of the senders.
std::vector<comm::Packet> exchange_bytes(PartState& part, std::vector<std::vector<std::byte>>& by_part);
// The first error of any part becomes that of all.
Result<void> agree_on_error(PartState& part, const Result<void>& mine);

}  // namespace meld::sim
