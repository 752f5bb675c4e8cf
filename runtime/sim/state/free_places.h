// Where catoms at arbitrary positions are in a snapshot: their homes, which processes own as they own bricks of a lattice, and their
// links with their ports, from which follows who is a ghost where. Positions are the motion's.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/sim/catoms/nodes.h"
#include "runtime/world/ensemble/ensemble.h"

namespace meld::sim {

class FreePlaces {
  public:
    // Catoms of one home follow each other.
    struct Home {
        world::BrickKey home = 0;
        std::uint32_t count = 0;
    };
    // It is the lower number's of the two.
    struct Link {
        std::uint32_t other = 0;
        std::uint32_t port = 0, port_there = 0;
    };
    // `homes` are those of the catoms. All have numbers below 2^32. Of nodes of a graph only where they are in
    // the order of nodes (Nodes), which is called their numbers here.
    static void save(const world::Ensemble& ensemble, const std::optional<Nodes>& nodes, std::span<const world::Catom> catoms,
                     std::span<const world::BrickKey> homes, ByteWriter& out);
    static Result<FreePlaces> read(ByteReader& in);

    const std::vector<Home>& homes() const { return homes_; }
    const std::vector<std::uint32_t>& ids() const { return ids_; }
    std::span<const Link> links(std::size_t i) const {
        return std::span(links_).subspan(first_link_[i], first_link_[i + 1] - first_link_[i]);
    }

  private:
    std::vector<Home> homes_;
    std::vector<std::uint32_t> ids_;
    std::vector<std::size_t> first_link_;
    std::vector<Link> links_;
};

}  // namespace meld::sim
