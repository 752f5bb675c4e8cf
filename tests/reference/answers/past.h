// What there was after every tick of a run: what was given and sensed, and the facts that the runtime had then.
#pragma once

#include <vector>

#include "runtime/sim/simulation.h"
#include "tests/reference/evaluator/facts_text.h"
#include "tests/reference/programs/draft.h"
#include "tests/reference/trials/scene.h"

namespace meld::reference {

struct Moment {
    Scene scene;
    Facts given;  // From outside, and still there.
    Facts facts;  // Those of the program's predicates, persistent and linear ones, and those of the world, with all links.
    std::vector<Bag> linear;
    Facts fronts;  // Values of which a better one may hold, and that the run keeps for what rests on them.
};

class Past {
  public:
    // Steps the run from its start until it ends, fails, or has reached this tick. `world` is on one clock.
    Past(const Trial& trial, const check::Program& program, sim::Simulation& simulation, std::int64_t last);

    const Program& program() const { return program_; }
    std::int64_t last() const { return static_cast<std::int64_t>(moments_.size()) - 1; }
    bool has(std::int64_t tick) const { return tick >= 0 && tick <= last(); }
    const Moment& at(std::int64_t tick) const { return moments_[static_cast<std::size_t>(tick)]; }
    // All that was ever given from outside, linear facts too.
    const Facts& given_ever() const { return given_ever_; }
    // Whether nothing is left to do after the last tick.
    bool quiet() const { return quiet_; }
    bool holds(std::int64_t tick, PredicateId p, const Row& row) const { return at(tick).facts[p.index()].contains(row); }
    // Whether some fact of these fits.
    static bool any(const Facts& facts, const Pattern& pattern);

  private:
    void apply(const retraction::Change& change, retraction::Mirror& mirror);
    void add_stable();

    const Program& program_;
    std::vector<Moment> moments_;
    Facts given_ever_;
    bool quiet_ = false;
};

}  // namespace meld::reference
