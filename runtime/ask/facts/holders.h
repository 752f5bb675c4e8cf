// Which catoms of this process hold facts of some predicates, kept from tick to tick by what changes: a search for all facts of a predicate
// of which there are few begins with its catoms, and does not look at all others.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "runtime/sim/core/subdomain.h"

namespace meld::inspect {

class Holders {
  public:
    // Of these predicates, which are stored. The subdomain outlives it.
    Holders(sim::Subdomain& subdomain, std::vector<u32> predicates);

    // Takes note of what has changed since the last call. Cost: at first all catoms, then those that have been touched.
    void update();

    // The number and index of each catom of this process that holds facts of the predicate, by their numbers, until the next update();
    // nothing if the predicate is none of these, or so common that to look at all catoms is no more work.
    const std::vector<std::pair<u64, sim::Catom>>* few(u32 predicate);

  private:
    struct Of {
        u32 predicate = 0;
        std::vector<u64> words = {};  // A bit for each catom.
        std::size_t count = 0;        // Of bits.
        bool listed = false;
        std::vector<std::pair<u64, sim::Catom>> by_id = {};
    };
    void note(Of& one, std::span<const sim::Catom> catoms) const;
    void list(Of& one) const;

    sim::Subdomain& subdomain_;
    sim::Touched& touched_;
    std::vector<Of> all_;
    std::vector<sim::Catom> changed_;  // Room for those that have been touched.
};

}  // namespace meld::inspect
