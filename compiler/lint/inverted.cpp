#include "compiler/lint/inverted.h"

#include <set>
#include <utility>
#include <vector>

#include "compiler/check/program/improvement.h"
#include "compiler/lint/linear_form.h"

namespace meld::lint {

using namespace check;

namespace {

// How a value passes from one predicate to another.
struct Way {
    PredicateId from, to;
    bool turns = false;  // The better the value there, the worse the one here.
    Inverted at;
};

class InvertedSearch {
  public:
    InvertedSearch(const Program& program, const check::Stratum& stratum) : program_(program), stratum_(stratum) {}

    std::optional<Inverted> run() {
        for (const RuleId id : stratum_.rules) add_ways(program_.rules[id]);
        for (const Way& w : ways_)
            if (w.turns && leads_back(w)) return w.at;
        return std::nullopt;
    }

  private:
    static bool best(const Predicate& p) { return keeps_best(p.aggregate); }

    void add_ways(const Rule& rule) {
        const Atom& head = rule.heads[0].atom;
        const Predicate& to = program_.predicates[head.predicate];
        if (!best(to)) return;
        const Term& made = head.arguments[to.aggregate_at];
        for (const Clause& c : rule.body) {
            if (c.kind != Clause::Kind::Atom || !stratum_.contains(c.atom.predicate)) continue;
            const Predicate& from = program_.predicates[c.atom.predicate];
            if (!best(from)) continue;
            const Term& value = c.atom.arguments[from.aggregate_at];
            const Inverted at{c.atom.predicate, c.atom.span, made.span};
            if (c.atom.predicate == head.predicate && of_another_group(head, c.atom, to)) continue;
            if (!value.is_variable()) {
                if (c.atom.predicate == head.predicate && better(made, value, to))
                    ways_.push_back({head.predicate, head.predicate, true, at});
                continue;
            }
            const Improvement improvement(program_, rule, c.atom, value.variable, from.aggregate);
            const bool alike = keeps_least(from.aggregate) == keeps_least(to.aggregate);
            if (improvement.follows(made)) ways_.push_back({c.atom.predicate, head.predicate, !alike, at});
            if (improvement.opposes(made)) ways_.push_back({c.atom.predicate, head.predicate, alike, at});
        }
    }

    // lit(A, 2, ~X) :- lit(A, 1, X).
    static bool of_another_group(const Atom& made, const Atom& read, const Predicate& p) {
        for (std::size_t i = 1; i < p.aggregate_at; ++i) {
            const auto one = literal(made.arguments[i]), other = literal(read.arguments[i]);
            if (one && other && *one != *other) return true;
        }
        return false;
    }

    // For bools. Numbers have others between and beyond them, which requires a look at all rules (replaced.h).
    static bool better(const Term& made, const Term& asked, const Predicate& p) {
        const auto one = literal(made), other = literal(asked);
        return made.type == Type::Bool && one && other && (keeps_least(p.aggregate) ? *one < *other : *one > *other);
    }

    // Whether the value returns to where it is read after an odd number of inversions.
    bool leads_back(const Way& first) const {
        using State = std::pair<PredicateId, bool>;
        std::set<State> seen;
        std::vector<State> todo{{first.to, true}};
        while (!todo.empty()) {
            const State at = todo.back();
            todo.pop_back();
            if (at == State{first.from, true}) return true;
            if (!seen.insert(at).second) continue;
            for (const Way& w : ways_)
                if (w.from == at.first) todo.push_back({w.to, at.second != w.turns});
        }
        return false;
    }

    const Program& program_;
    const check::Stratum& stratum_;
    std::vector<Way> ways_;
};

}  // namespace

std::optional<Inverted> inverts_itself(const Program& program, const check::Stratum& stratum) {
    return InvertedSearch(program, stratum).run();
}

}  // namespace meld::lint
