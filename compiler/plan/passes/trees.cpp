// Trees: a strongly connected component that recurs over links through a sum is not recursive at one catom, or only through sets. So its
// predicates are split into separate strata, in an order in which predicates read at the same catom come first:
//     up(A, sum) :- tree(B, A), ready(B, S).      ready(A, S) :- up(A, S).
// evaluates up and then ready; what is read at neighbours is as of the last tick in any case.
#include <algorithm>

#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

class Tree {
  public:
    Tree(const Program& program, const check::Stratum& whole) : program_(program), whole_(whole), reads_(whole.predicates.size()) {}

    std::vector<check::Stratum> parts() {
        for (const RuleId id : whole_.rules) {
            const Rule& rule = program_.rules[id];
            each_atom(rule.body, [&](const Atom& a, bool) {
                if (a.arguments[0].variable == rule.site && inside(a.predicate))
                    reads_[number(rule.heads[0].atom.predicate)].push_back(number(a.predicate));
            });
        }
        // Predicates that reach each other form one part; a part follows all the parts that it reads.
        std::vector<check::Stratum> out;
        std::vector<bool> done(reads_.size(), false);
        while (out.empty() || std::find(done.begin(), done.end(), false) != done.end()) {
            const std::size_t before = out.size();
            for (std::size_t p = 0; p < reads_.size(); ++p)
                if (!done[p] && ready(p, done)) out.push_back(part(p, done));
            MELD_CHECK(out.size() > before, "no part of a tree can be evaluated next");
        }
        MELD_ENSURE(out.size() <= whole_.predicates.size());
        return out;
    }

  private:
    bool inside(PredicateId p) const { return std::find(whole_.predicates.begin(), whole_.predicates.end(), p) != whole_.predicates.end(); }
    std::size_t number(PredicateId p) const {
        return static_cast<std::size_t>(std::find(whole_.predicates.begin(), whole_.predicates.end(), p) - whole_.predicates.begin());
    }
    // All that is read at the catom on the way from here.
    std::vector<std::size_t> reached(std::size_t from) const {
        std::vector<std::size_t> out = reads_[from];
        for (std::size_t i = 0; i < out.size(); ++i)
            for (const std::size_t next : reads_[out[i]])
                if (std::find(out.begin(), out.end(), next) == out.end()) out.push_back(next);
        return out;
    }
    bool reaches(std::size_t from, std::size_t to) const {
        const std::vector<std::size_t> all = reached(from);
        return std::find(all.begin(), all.end(), to) != all.end();
    }
    bool ready(std::size_t p, const std::vector<bool>& done) const {
        const std::vector<std::size_t> all = reached(p);
        return std::all_of(all.begin(), all.end(), [&](std::size_t q) { return done[q] || reaches(q, p); });
    }
    check::Stratum part(std::size_t p, std::vector<bool>& done) const {
        check::Stratum c;
        c.recursive = c.tree = true;
        c.links = whole_.links;
        c.rounds = whole_.rounds;
        c.local = reaches(p, p);
        for (std::size_t q = 0; q < reads_.size(); ++q) {
            if (q != p && !(reaches(p, q) && reaches(q, p))) continue;
            done[q] = true;
            c.predicates.push_back(whole_.predicates[q]);
        }
        for (const RuleId id : whole_.rules)
            if (std::find(c.predicates.begin(), c.predicates.end(), program_.rules[id].heads[0].atom.predicate) != c.predicates.end())
                c.rules.push_back(id);
        return c;
    }

    const Program& program_;
    const check::Stratum& whole_;
    std::vector<std::vector<std::size_t>> reads_;  // By predicate of the stratum: those it reads at the same catom.
};

}  // namespace

void split_trees(Program& program) {
    std::vector<check::Stratum> all;
    for (const check::Stratum& c : program.strata) {
        if (!c.tree) {
            all.push_back(c);
            continue;
        }
        for (check::Stratum& part : Tree(program, c).parts()) all.push_back(std::move(part));
    }
    program.strata = std::move(all);
}

}  // namespace meld::plan
