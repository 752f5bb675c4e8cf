// Which chunks of the catoms of a process have changed since a snapshot was taken, so that the next one makes only these. A chunk is that
// of catoms whose indices follow each other. Nothing is kept by chunk while a run goes on: a bit for each catom says whether it was
// touched.
#pragma once

#include <cstddef>
#include <vector>

#include "runtime/sim/core/subdomain.h"
#include "runtime/sim/state/share.h"

namespace meld::sim {

class ChangedChunks {
  public:
    // For worlds on lattices: of so many indices each. At first all have changed.
    explicit ChangedChunks(Subdomain& subdomain, std::size_t catoms = kCatomsOfASmallChunk)
        : subdomain_(subdomain), touched_(subdomain.follow(Follows::WhatIsHeld)), catoms_(catoms) {}
    std::size_t catoms() const { return catoms_; }

    // Between two ticks, before a snapshot. Cost: the catoms that were touched since the last call.
    void look();
    bool changed(std::size_t chunk) const { return chunk >= changed_.size() || changed_[chunk]; }
    std::vector<std::size_t> all_changed() const;
    // It counts as changed again in the next snapshot.
    void changes_by_itself(std::size_t chunk) { waits_[chunk] = true; }
    // The snapshot after look() is whole: from now on, what has changed has done so since it.
    void saved();

  private:
    // The agenda is emptied, and it is forgotten which rows have changed, without a word.
    void note_agenda(std::vector<bool>& chunks) const;

    Subdomain& subdomain_;
    Touched& touched_;  // The subdomain's.
    std::size_t catoms_;
    std::vector<bool> changed_;  // By chunk.
    std::vector<bool> waits_;    // Those that will change without being touched.
};

}  // namespace meld::sim
