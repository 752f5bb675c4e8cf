// The bodies of a run on several processes: each process holds those in its blocks of space and, as ghosts, those around. Transports the
// messages of physics/scene/subdomain.h; the results are those of the undivided world, bit for bit.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "physics/scene/subdomain.h"
#include "runtime/sim/core/subdomain.h"
#include "runtime/world/partition/partition.h"

namespace meld::sim {

// The place of a block of space on the curve by which processes divide it.
world::BrickKey place_on_curve(physics::BlockCoordinates block);

class DividedBodies {
  public:
    // Every process calls it; the scene has this process's bodies, wherever they are.
    DividedBodies(Subdomain& subdomain, physics::Scene& scene);
    // Of a run that goes on: space is divided as its catoms have been, and the scene is still empty.
    DividedBodies(Subdomain& subdomain, physics::Scene& scene, const partition::Partition& partition);
    // On every process, before Scene::loaded: our homes of a snapshot become ghosts of those who hold them, and theirs become ghosts here.
    Result<void> load_ghosts(Subdomain& subdomain, physics::Scene& scene, const std::vector<physics::SavedHome>& ours);
    // The same of bodies that joints and connections hold to others, and of these pairs, if the snapshot has any: on every process, behind
    // load_ghosts, which is not needed before anything has moved.
    Result<void> load_joined(Subdomain& subdomain, std::span<const physics::ConnectionPair> also);
    // After Scene::loaded.
    void loaded() { subdomain_->loaded(); }

    // Before a step, on every process: returns whether bodies have migrated. Bodies that are no longer ours are in departed(). Space is
    // divided along a curve through the blocks so that all processes have about the same work, and divided again when one has too much.
    Result<bool> redistribute(Subdomain& subdomain, double step_s, int substeps);
    const std::vector<std::pair<physics::BodyId, int>>& departed() const { return subdomain_->departed(); }
    // A step. If a process has an error, all return that of the first such process.
    Result<physics::StepReport> step(Subdomain& subdomain, double step_s, int substeps);
    // After Scene::sum_normal_forces, on every process: adds the normal forces on our bodies that other processes know.
    void complete(Subdomain& subdomain, std::vector<ExactSum>& normal_forces) const;
    // The owner of a body that is ours or next to ours, since the last step in which bodies migrated.
    int owner_of(physics::BodyId body) const { return subdomain_->owner_of(body); }
    // The other processes that have the body, as its owner or as a ghost. Ascending.
    const std::vector<int>& holders_of(physics::BodyId body) const { return subdomain_->holders_of(body); }

    // How often space was divided again after the start, and the greatest work of a process after bodies migrated, as a multiple of the
    // mean; the same on all processes.
    int divisions() const { return divisions_; }
    double greatest_load() const { return greatest_load_; }

  private:
    int owner(physics::BlockCoordinates block) const;
    // Composites change: brings their bodies together, on every process.
    Result<void> recompose(Subdomain& subdomain);
    // Divides space again if the process with the most work has too much.
    void balance(Subdomain& subdomain);
    // The work in each block, the same on all processes.
    using Weights = std::vector<std::pair<world::BrickKey, std::uint32_t>>;
    Weights weigh_all(Subdomain& subdomain) const;

    std::optional<partition::Partition> partition_;
    mutable std::unordered_map<std::uint64_t, int> owners_;  // The owners of blocks that were asked for.
    std::unique_ptr<physics::Subdomain> subdomain_;
    int divisions_ = 0;
    double greatest_load_ = 0;
};

// Gives all processes the bytes of all, in the order of processes; a single process gets its own.
std::vector<std::vector<std::byte>> gather_bytes(Subdomain& subdomain, ByteWriter& mine);
inline physics::ConnectionPair pair_of(physics::BodyId one, physics::BodyId other) { return std::minmax(one, other); }
// Pairs of all processes, of which several may have the same; sorted, each once.
std::vector<physics::ConnectionPair> gather_pairs(Subdomain& subdomain, const std::vector<physics::ConnectionPair>& ours);
// Sends bytes to processes by number (none to itself), and returns what arrives, in the order of the senders.
std::vector<comm::Packet> exchange_bytes(Subdomain& subdomain, std::vector<ByteWriter>& by_process);
// The first error of any process becomes the error of all.
Result<void> agree_on_error(Subdomain& subdomain, const Result<void>& mine);

}  // namespace meld::sim
