// The facts that the world gives to its catoms, at the start and while they run.
#pragma once

#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/sim/core/failures/dead_links.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

// The predicates that rules read, of which no rule, no fact of the text and no fact or event of the world makes any, in the order of the
// program; sensed ones and actions are not among them. Of several with one name: "p/2", with the number of its arguments.
std::vector<std::string> never_given(const ModuleInfo& module, const world::World& world);

class GivenFacts {
  public:
    explicit GivenFacts(Subdomain& subdomain) : subdomain_(subdomain), dead_links_(subdomain) {}

    // The facts of the start; those of events are checked. Every process calls it. Errors: the world gives something that the program
    // cannot take.
    Result<void> start();
    // The facts of the start, again, for catoms of this process that have none.
    void give_again(const std::vector<Catom>& catoms);
    // Only those of events: for a run that does not begin at the start. Every process calls it.
    Result<void> check_events();
    // A fact that is given or taken later. Errors: the world could not give it.
    Result<void> check(const world::GivenFact& fact) { return change_one(fact, Change::Check); }
    // The facts of this tick's events.
    void change();

  private:
    enum class Change { Check, Give, Take, Look };
    // Catoms of a region, and those of them whose facts have changed, or at which the fact holds.
    struct Reached {
        u64 matched = 0, changed = 0;
    };
    // Facts, and for each how many catoms of this process its region matches.
    struct Matched {
        std::vector<const world::GivenFact*> facts;
        std::vector<u64> catoms;
    };
    Result<void> look_at_events(Matched& all);
    // Gives the fact to the catoms of its region, or takes it from them; Look only finds where it holds, and Check reports what is wrong
    // with it. `reached` counts the catoms of this process; with Check it says whether the region has any.
    Result<void> change_one(const world::GivenFact& fact, Change how, Reached* reached = nullptr, const std::vector<Catom>* only = nullptr);
    // Gives a stored predicate to the catoms of a region, or takes it from them, on all workers.
    Reached change_all(const world::GivenFact& fact, u32 predicate, Change how, const Value* arguments);
    // Takes a fact, and warns if nobody in its region had it among those that are given. Every process calls it.
    void take(const world::Event& event, const world::GivenFact& fact);
    Reached sum_of_all(Reached mine);
    // Whether the fact holds at the catom, given or derived.
    bool holds(u32 predicate, Catom catom, const Value* arguments) const;
    // Whether the fact is given at the start and is a route in a world without motion.
    std::optional<std::size_t> as_route(const world::GivenFact& fact, const PredicateInfo& p, Change how) const;
    // Warns of the facts that no process has a catom for.
    void warn_of_unmatched(const Matched& all);
    // The catoms and their positions do not change.
    bool still() const { return subdomain_.world.motion.kind == "none" && subdomain_.world.components.empty(); }
    void warn_of_missing_catoms();

    Subdomain& subdomain_;
    DeadLinks dead_links_;
};

}  // namespace meld::sim
