// The clauses of a body that are not steps yet, and which of them can be next.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "compiler/plan/access.h"

namespace meld::plan {

// The order in which clauses are read: by access cost, or as written, which is what linear rules mean.
enum class Reading { Cheapest, AsWritten };

// A clause is looked at again only when one of its variables has become known, or belongs to no other clause any more: each step of a long
// body costs about as much as one of a short body.
class OpenBody {
  public:
    // `outside` are variables that clauses outside bind or use.
    OpenBody(std::vector<check::Clause> body, const AccessPlanner& accesses, Reading reading, const Known& known, const Variables& outside);

    bool empty() const { return left_ == 0; }
    std::size_t left() const { return left_; }
    const check::Clause& clause(std::size_t i) const { return clauses_[i]; }

    // The first test, negation or aggregate that may have become ready; it is returned once, until it may have become so anew.
    std::optional<std::size_t> next_without_read();
    // The clause to read next; none: none can be read yet.
    std::optional<std::size_t> next_read() const;
    // Why that clause is read next, by what was known before it.
    Choice choice(std::size_t next, const Known& known) const;
    // Of the variables of a negation or aggregate, those that are no variables of its own: another one of the same name in another negation
    // or aggregate is a different one.
    Variables shared_by(const check::Clause& clause) const;

    // The clause has become steps, by which `known` has grown.
    void close(std::size_t i, const Known& known);
    // What is left, in order.
    std::vector<check::Clause> rest() &&;

  private:
    struct Variable {
        std::vector<std::size_t> users;  // The clauses that mention it.
        std::size_t sharers = 0;         // Mentions in clauses that are left and share their variables with others.
        bool value = false, place = false;
    };
    void look_again(std::size_t i, const Known& known);

    const AccessPlanner& accesses_;
    Reading reading_;
    const Variables& outside_;
    std::vector<check::Clause> clauses_;
    std::vector<bool> closed_;
    std::vector<std::optional<int>> costs_;  // By clause, if it can be read.
    std::set<std::pair<int, std::size_t>> readable_;
    std::set<std::size_t> may_be_ready_;
    std::map<VariableId, Variable> variables_;
    std::size_t left_, first_left_ = 0;
};

}  // namespace meld::plan
