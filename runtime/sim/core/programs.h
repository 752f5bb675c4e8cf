// Which of several programs each catom runs: a fact that it senses from its start and keeps wherever it goes. The rules of each program
// read it (compiler/check/names/programs.cpp).
#pragma once

#include <optional>

#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

class Programs {
  public:
    explicit Programs(Subdomain& subdomain);

    // For all catoms of this process at the start of a run; warns of regions without catoms. Collective.
    void start();
    // After facts of another run have been loaded: for catoms that run none of the programs yet.
    void complete();
    // For a catom of this process that has just been created: by the region of its cell.
    void begin(Catom catom);

  private:
    // Of the last region that it is in; 0: it is in none.
    std::uint32_t number_of(Catom catom) const;
    void give(Catom catom, std::uint32_t number);

    Subdomain& subdomain_;
    std::optional<u32> predicate_;  // None: no rule reads it.
};

}  // namespace meld::sim
