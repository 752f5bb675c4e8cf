// One application of a linear rule at a catom: what it consumes, and what it makes.
#pragma once

#include <set>

#include "tests/reference/evaluator/solver.h"

namespace meld::reference {

// A fact that a rule has made.
struct Made {
    PredicateId predicate;
    Row row;
    std::vector<std::int64_t> way = {};  // The catoms it goes through, with where it goes; none: it is made where the rule runs.
    std::int64_t delay = 0;              // In ticks from now.
    bool far = false;                    // No link of the bodies leads to the last of them.
    bool begins = false;                 // It is at a node that the rule makes.
};

class Application {
  public:
    // linear: the catom's bags, from which it consumes.
    Application(const check::Rule& rule, const Sight& sight, std::vector<Bag>& linear);

    // False: there is no way to satisfy the body, and nothing has been done. All of what it makes is made when it is
    // through, so none of its own comprehensions sees it.
    bool run(std::int64_t site);

    std::vector<Made> made;
    std::vector<std::int64_t> born;  // Numbers of nodes that it makes, if it makes facts there.
    bool failed = false;

  private:
    using Bodies = std::vector<const std::vector<check::Clause>*>;
    struct Match {
        Environment env;
        std::vector<Taken> taken;
    };

    // The ways to satisfy a body, in order; one: the first alone.
    enum class Which { All, First };
    std::vector<Match> matches(const std::vector<check::Clause>& body, const Environment& env, Which which);
    const Match* select(const std::vector<Match>& all);
    void consume(const std::vector<Taken>& taken);

    void heads(const std::vector<check::Head>& all, const Environment& env, const Bodies& bodies);
    bool makes_node(const check::Head& h) const;
    void fact(const check::Head& h, const Environment& env, const Bodies& bodies);
    void aggregate(const check::Head& h, const Environment& env, const Bodies& bodies);
    // Calls visit(env) for every match of the head's body, in which it has been consumed. Where it consumes, it goes on as
    // long as something is left; else there is one for every way.
    template <class Visit>
    void each_match(const check::Head& h, const Environment& env, const Visit& visit);
    // The catoms on a shortest way over the links of the bodies from the rule's execution site to the place of a head.
    // far: no link of the bodies leads there.
    std::vector<std::int64_t> way(check::VariableId goal, const Environment& env, const Bodies& bodies, bool& far) const;

    const Program& program_;
    const check::Rule& rule_;
    const Sight sight_;
    std::vector<Bag>& linear_;
    std::set<check::VariableId> born_at_;  // The variables of nodes that it makes.
};

}  // namespace meld::reference
