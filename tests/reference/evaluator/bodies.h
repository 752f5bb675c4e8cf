// Bodies of rules in the states that a run had. Who judges answers looks there whether they are satisfied, and prints them as an answer
// does.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/reference/answers/past.h"
#include "tests/reference/evaluator/expressions.h"

namespace meld::reference {

using Clauses = std::vector<check::Clause>;

// A head of a rule, with what must be satisfied for it: the rule's body, then the bodies and conditions around the head.
struct HeadOf {
    const check::Rule* rule = nullptr;
    const check::Head* head = nullptr;
    Clauses clauses = {};
    bool of_results = false;  // It stands behind aggregates of heads, whose results no clause says.
};
// Those that give facts of a predicate: of the rules that derive, or of linear rules; in the order of the text.
enum class RuleKind { View, Linear };
std::vector<HeadOf> heads_of(const check::Program& program, PredicateId p, RuleKind kind);

// In which states a body is read. Spread: what is behind k links is that of k ticks before, as far as it takes to come here.
struct When {
    std::int64_t tick = 0;
    bool spread = false;
};

// Whether a body asks for what no state tells: a change, the time, a random number.
bool beyond_states(const Clauses& body);
bool beyond_states(const check::Term& term);

class Bodies {
  public:
    explicit Bodies(const Past& past) : past_(past) {}

    // How many ticks before it runs a rule reads each atom of its body, also within its parts.
    struct Ages {
        std::map<const check::Atom*, std::int64_t> read;
        // Of facts that point from a catom to the next: when a link had to be between the two.
        std::map<const check::Atom*, std::int64_t> linked;
        std::int64_t at(const check::Atom* atom) const { return read.at(atom); }
    };
    static Ages ages(const check::Program& program, const check::Rule& rule, const Clauses& clauses);

    struct Search {
        const check::Rule& rule;
        const Clauses& clauses;  // All of a body, or a part of it.
        const Ages& ages;        // Of the whole.
        When when;
        Environment env;
        // Atoms that may match only these.
        std::map<const check::Atom*, Rows> named = {};
    };
    // Calls found(env) for every way, until it returns true; returns whether it did.
    bool solve(const Search& search, const std::function<bool(const Environment&)>& found) const;

    // As an answer prints it: variables that have a value are named by it.
    std::string print(const check::Rule& rule, const Environment& env, const check::Clause& clause) const;
    std::string print(const check::Rule& rule, const Environment& env, const Clauses& clauses) const;
    std::string print(const check::Rule& rule, const Environment& env, const check::Atom& atom) const;
    // A test that says of a value only what it is is not printed.
    bool says_nothing(const check::Rule& rule, const Environment& env, const check::Term& test) const;

    // The values that an answer gives its variables. Nothing: it names one that there is not, or it is no value of its type.
    std::optional<Environment> environment(const HeadOf& head, const std::map<std::string, std::string>& with) const;

  private:
    check::Rule named(const check::Rule& rule, const Environment& env) const;

    const Past& past_;
};

}  // namespace meld::reference
