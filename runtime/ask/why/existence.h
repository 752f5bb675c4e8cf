// Groups of min and max of which rules of a recursion ask only whether they have a value: the run keeps that beside the values
// (compiler/plan/passes/exists.cpp), in a recursion of its own with its own ranks.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "runtime/ask/facts/facts.h"
#include "runtime/ask/query/order.h"
#include "runtime/ask/query/terms.h"

namespace meld::inspect {

class Existence {
  public:
    explicit Existence(const Program& program);

    bool any() const { return !groups_.empty(); }
    // The rules by which the run derives facts of the predicate: max(X, Y) of a max is two rules, one for X and one for Y.
    const std::vector<const check::Rule*>& views(check::PredicateId id) const { return views_[id.index()]; }

    // Whether an atom of the rule's body asks only whether its group has a value: then this is what may be of lower rank, and not the
    // value that is there. `body` may have more clauses than the rule; `open`: of the head the value may be any.
    bool asks(const check::Rule& rule, const std::vector<check::Clause>& body, const Bound& bound, bool open,
              const check::Clause& clause) const;
    // A fact of a predicate, or only that its group has one.
    struct What {
        check::PredicateId predicate;
        bool exists = false;
        auto operator<=>(const What&) const = default;
    };
    // Whether ranks say which of the two may rest on the other: they are of one recursion.
    bool comparable(const What& head, const What& read) const { return same_recursion_.contains({head, read}); }

    // The facts, with groups that have a value in place of the values; what is behind the group is not to be looked at.
    std::unique_ptr<Facts> groups_of(Facts& facts) const;

  private:
    void find_groups();
    void find_views();
    void find_recursions();

    const Program& program_;
    std::map<check::PredicateId, Source> groups_;  // Where they are kept apart.
    std::deque<check::Rule> sides_;
    std::vector<std::vector<const check::Rule*>> views_;  // By predicate.
    std::set<std::pair<What, What>> same_recursion_;
};

}  // namespace meld::inspect
