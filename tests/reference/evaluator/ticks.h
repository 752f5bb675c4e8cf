// Linear rules tick by tick. Every catom has its facts; in a tick each evaluates its views from scratch, with what its
// neighbours showed at the end of the last tick, and applies linear rules one by one, the first of the text each time.
// Only for views whose facts are certain in every tick: those that look one link far at most and not through a recursion
// over links. Other views are checked where nothing changes any more (model.h).
#pragma once

#include <set>
#include <tuple>

#include "tests/reference/evaluator/application.h"
#include "tests/reference/evaluator/model.h"

namespace meld::reference {

class Ticks {
  public:
    // seed: of the world, for what is drawn.
    explicit Ticks(const Program& program, std::uint64_t seed = 0);

    // Views whose facts are certain in every tick.
    bool certain(PredicateId p) const { return certain_[p.index()]; }

    // Facts from outside, between ticks. Persistent and linear ones.
    void give(PredicateId p, Row row);
    void take(PredicateId p, const Row& row);
    // One tick; the scene says which catoms there are.
    void step(const Scene& scene);
    // A catom is there before the first tick. Those of a graph in the order of their numbers.
    void know(std::int64_t id);
    // The links that there are then, by which facts find their ways in it.
    void know(const Links& links) { ways_before_ = links; }
    // How facts of a graph go to nodes that no link need lead to: in one hop, or over shortest ways of links.
    enum class Ways { Hop, Routes };
    void find_ways(Ways ways) { ways_ = ways; }
    // Nodes that rules have made in the last tick, by their numbers, and which node made each.
    const std::map<std::int64_t, std::int64_t>& born() const { return born_; }

    // As of the end of the last tick.
    Facts views() const;  // Certain ones.
    Facts given() const;  // Persistent facts from outside and from linear rules.
    std::vector<Bag> linear() const;
    // Persistent facts that were sent in it. The next tick sees them; where they are stored they may be found already.
    Facts arriving() const;
    bool failed() const { return failed_; }
    // Some catom made more facts in a tick than a test should wait for.
    bool ran_away() const { return ran_away_; }

  private:
    // A fact that is there from a tick on; 0: at once.
    struct Later {
        std::int64_t due;
        PredicateId predicate;
        Row row;
        bool operator<(const Later& other) const { return std::tie(due, predicate, row) < std::tie(other.due, other.predicate, other.row); }
    };
    struct Message {
        std::vector<std::int64_t> way;  // The next catom first.
        Later fact;
        bool far = false;
    };
    struct Catom {
        Facts given, views;
        Facts before;  // The views at the end of the last tick.
        std::vector<Bag> linear;
        std::multiset<Later> waiting = {};
        std::vector<Message> passing = {};     // To be handed on.
        std::set<PredicateId> undefined = {};  // Views of which some derivation has no value.
        // Of delayed views, by rule: since when each derivation has held. It is the head's row, and where derivations are
        // counted, behind it the facts that the body found and the places of elements in lists.
        std::map<check::RuleId, std::map<Row, std::int64_t>> since = {};
    };

    Catom empty() const;
    void find_certain();
    void tell_apart();
    bool looks_far(const check::Rule& rule) const;
    void evaluate(const Scene& scene, std::int64_t id, Catom& catom);
    void put(const Scene& scene, std::int64_t id, Catom& catom, Made&& made);
    void send(const Scene& scene, std::int64_t from, Message&& message);
    void send_far(const Scene& scene, std::int64_t from, Catom& catom, Message&& message);
    std::int64_t next_hop(const Scene& scene, std::int64_t from, std::int64_t goal) const;
    void bear();
    void deliver(Message&& message);
    bool receive_one(std::int64_t now, Catom& catom);
    // Returns whether all derivations had values.
    bool derive_at(const Scene& scene, std::int64_t id, Catom& catom, check::RuleId rule, const Facts& seen, std::vector<Derived>& rows);
    void settle(const Scene& scene, std::int64_t id, Catom& catom);
    bool would_read_undefined(const Catom& catom) const;
    bool fire(const check::Rule& rule, const Scene& scene, const Facts& seen, std::int64_t id, Catom& catom);
    Facts visible(const Scene& scene, std::int64_t id, const Catom& catom) const;

    const Program& program_;
    // Delayed rules whose derivations count, with a variable for each `_` and each place in a list.
    std::map<check::RuleId, check::Rule> counted_;
    std::map<PredicateId, PredicateId> returned_;  // Where undelivered facts of a predicate go.
    std::uint64_t seed_;
    std::vector<bool> certain_;
    std::map<std::int64_t, Catom> catoms_;
    std::map<std::int64_t, Facts> shown_;  // The views at the end of the last tick,
    Links links_before_;                   // and the links in it.
    std::set<std::int64_t> known_;         // The catoms that there were.
    Ways ways_ = Ways::Hop;
    Links ways_before_;  // As links_before_, but known before the first tick.
    // All nodes that there ever were, in order, and a number above those of all that were made.
    std::vector<std::int64_t> nodes_;
    std::int64_t next_node_ = 0, greatest_node_ = -1;
    std::map<std::int64_t, std::int64_t> born_;
    std::map<std::int64_t, std::vector<Later>> first_facts_;  // Of nodes that are made in this tick.
    std::vector<Message> messages_;
    bool failed_ = false, ran_away_ = false;
};

}  // namespace meld::reference
