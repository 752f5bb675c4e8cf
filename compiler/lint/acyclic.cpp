#include "compiler/lint/acyclic.h"

#include <algorithm>
#include <map>
#include <set>
#include <vector>

namespace meld::lint {

using namespace check;

namespace {

// As runtime/sim/core/setup/graph_facts.h gives it.
constexpr const char* kLink = "link";

class Followed {
  public:
    Followed(const Program& program, const Stratum& stratum) : program_(program), stratum_(stratum) {}

    bool run() {
        for (const Rule& rule : program_.rules)
            if (std::ranges::any_of(rule.heads, [&](const Head& head) { return is_link(head.atom.predicate); })) return false;
        for (const RuleId id : stratum_.rules) look_at(program_.rules[id]);
        return !astray_ && !(forward_ && backward_) && stays_end();
    }

  private:
    bool is_link(PredicateId id) const {
        const Predicate& p = program_.predicates[id];
        return p.name == kLink && p.world == WorldSource::None && p.kind == PredicateKind::Persistent && p.arguments.size() >= 2;
    }
    bool is_link(const Atom& a) const { return is_link(a.predicate) && a.arguments[1].is_variable(); }

    void look_at(const Rule& rule) {
        for (const Head& head : rule.heads) {
            if (!stratum_.contains(head.atom.predicate)) continue;
            const VariableId to = head.atom.arguments[0].variable;
            each_atom(rule.body, [&](const Atom& a, bool) {
                if (!stratum_.contains(a.predicate)) return;
                const VariableId from = a.arguments[0].variable;
                const bool there = leads(rule, from, to), back = leads(rule, to, from);
                if (from == to)
                    stays_[a.predicate].insert(head.atom.predicate);
                else if (there == back)
                    astray_ = true;
                else
                    (there ? forward_ : backward_) = true;
            });
        }
    }

    // Whether links of the body, one after the other, lead from one catom to the other.
    bool leads(const Rule& rule, VariableId from, VariableId to) const {
        std::vector<VariableId> reached{from};
        for (std::size_t at = 0; at < reached.size(); ++at)
            for (const Clause& clause : rule.body) {
                if (clause.kind != Clause::Kind::Atom || !is_link(clause.atom) || clause.atom.arguments[0].variable != reached[at])
                    continue;
                const VariableId next = clause.atom.arguments[1].variable;
                if (next == to) return true;
                if (std::ranges::find(reached, next) == reached.end()) reached.push_back(next);
            }
        return false;
    }

    // Whether facts of one catom do not lead to themselves without a link.
    bool stays_end() const {
        for (const auto& [start, heads] : stays_) {
            std::vector<PredicateId> reached(heads.begin(), heads.end());
            for (std::size_t at = 0; at < reached.size(); ++at) {
                if (reached[at] == start) return false;
                const auto more = stays_.find(reached[at]);
                if (more == stays_.end()) continue;
                for (const PredicateId next : more->second)
                    if (std::ranges::find(reached, next) == reached.end()) reached.push_back(next);
            }
        }
        return true;
    }

    const Program& program_;
    const Stratum& stratum_;
    bool forward_ = false, backward_ = false, astray_ = false;
    std::map<PredicateId, std::set<PredicateId>> stays_;  // By predicate, those that are derived of it at the same catom.
};

}  // namespace

bool ends_with_links(const Program& program, const Stratum& stratum) { return Followed(program, stratum).run(); }

}  // namespace meld::lint
