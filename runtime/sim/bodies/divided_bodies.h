// The bodies of a run on several processes: each process holds those in its blocks of space and, as ghosts, those around. Carries
// the messages of physics/scene/subdomain.h; the bits are those of the undivided world.
#pragma once

#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "physics/scene/subdomain.h"
#include "runtime/partition/partition.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

class DividedBodies {
  public:
    // Every process calls it; the scene has this process's bodies, wherever they are.
    DividedBodies(Subdomain& subdomain, physics::Scene& scene);

    // Before a step, on every process: whether bodies have changed hands. Those that were ours and are no more are in departed().
    // Space is divided along a curve through the blocks so that all processes have about the same work; it is divided again when
    // one has too much.
    Result<bool> redistribute(Subdomain& subdomain, double step_s, int substeps);
    const std::vector<std::pair<physics::BodyId, int>>& departed() const { return subdomain_->departed(); }
    // A step. The error of the first process that has one is everybody's.
    Result<physics::StepReport> step(Subdomain& subdomain, double step_s, int substeps);
    // After Scene::sum_normal_forces, on every process: what others know of presses on our bodies is added.
    void complete(Subdomain& subdomain, std::vector<ExactSum>& normal_forces) const;
    // Of bodies that are ours or next to ours; since the last step in which bodies changed hands.
    int owner_of(physics::BodyId body) const { return subdomain_->owner_of(body); }
    // The other processes that have the body too. Ascending.
    const std::vector<int>& holders_of(physics::BodyId body) const { return subdomain_->holders_of(body); }

    // How often space was divided again after the start, and the greatest share of the work that a process had after bodies changed
    // hands, in shares of the mean; the same on all processes.
    int divisions() const { return divisions_; }
    double greatest_load() const { return greatest_load_; }

  private:
    int owner(physics::BlockCoordinates block) const;
    world::BrickKey key_of(physics::BlockCoordinates block) const;
    // Divides space again if the process with most work has too much.
    void balance(Subdomain& subdomain);
    // The work in each block, the same on all processes.
    using Weights = std::vector<std::pair<world::BrickKey, std::uint32_t>>;
    Weights weigh_all(Subdomain& subdomain) const;

    // Blocks lie on the curve of a lattice's bricks, however the catoms began.
    world::Lattice curve_{world::LatticeKind::Cubic};
    std::optional<partition::Partition> partition_;
    mutable std::unordered_map<std::uint64_t, int> owners_;  // Of blocks that have been asked for.
    std::unique_ptr<physics::Subdomain> subdomain_;
    int divisions_ = 0;
    double greatest_load_ = 0;
};

// Gives all processes the bytes of all, in the order of processes; one process has its own.
std::vector<std::vector<std::byte>> gather_bytes(Subdomain& subdomain, ByteWriter& mine);
// Sends bytes to processes by number (none to itself), and returns what came, in the order of the senders.
std::vector<comm::Packet> exchange_bytes(Subdomain& subdomain, std::vector<ByteWriter>& by_process);
// The first error of any process becomes that of all.
Result<void> agree_on_error(Subdomain& subdomain, const Result<void>& mine);

}  // namespace meld::sim
