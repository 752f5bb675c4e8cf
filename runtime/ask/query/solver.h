// Finds all ways to satisfy a body in one state of a run.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "compiler/check/program/program.h"
#include "runtime/ask/facts/facts.h"
#include "runtime/ask/query/index.h"
#include "runtime/ask/query/order.h"
#include "runtime/ask/query/terms.h"

namespace meld::inspect {

// One way to satisfy a body. Valid during the call that tells of it.
struct Solution {
    const Values& values;
    // By clause of the body: the fact that it matched, if it is an atom.
    std::span<const Fact* const> facts;
};

// How far a body can be satisfied, if it cannot as a whole: the steps that can be taken together, and the first that then cannot.
struct Attempt {
    std::size_t taken = 0;                  // Steps, in their order.
    const check::Clause* failed = nullptr;  // Null: the body was satisfied.
    Values values = {};                     // Of what was bound by the steps before; lists end with the search.
    Bound bound = {};
    std::vector<const check::Clause*> met = {};  // The parts of the body that these steps belong to, in their order.
};

struct SearchOptions {
    // Facts that may be used; empty: all. The clause is an atom of the body itself, not of a part of it.
    std::function<bool(const check::Clause& clause, const Fact& fact)> allowed = {};
    // Called now and then, with the number of facts that were looked at.
    std::function<void(std::uint64_t facts)> looked = {};
    // Goes on after a signal, until that has waited long enough: for a search that is part of a tick.
    bool patient = false;
    // Notes how far the best attempt came.
    Attempt* best = nullptr;
    // Called whenever an attempt has come further than all before, while its values are whole.
    std::function<void(const Attempt&)> further = {};
    // The state in which an atom is looked up, also one within a part of the body; empty: that of the solver.
    std::function<Facts&(const check::Clause& clause)> from = {};
    // Facts that could be read, also by atoms within a part of the body; empty: all.
    std::function<bool(const check::Clause& clause, const Fact& fact)> readable = {};
};

class Solver {
  public:
    // All outlive it. Indexes are kept from one search to the next.
    Solver(const Program& program, Facts& facts, Terms& terms) : program_(program), facts_(facts), terms_(terms) {}

    // Calls `found` for every way, until it says false. `bound` says which variables have their value in `values` already. The same ways
    // may come again, if facts agree that no variable names. Errors: a signal has asked for the end.
    using Found = std::function<bool(const Solution&)>;
    Result<void> search(const check::Rule& rule, const std::vector<check::Clause>& body, Values values, Bound bound, const Found& found,
                        const SearchOptions& options = {});

    // The same for each of these catoms in turn as the value of `start`, with one plan. `done` is called after each, and says whether to go
    // on.
    Result<void> search_from(const check::Rule& rule, const std::vector<check::Clause>& body, check::VariableId start,
                             std::span<const u64> catoms, const Found& found, const std::function<bool(std::size_t)>& done,
                             const SearchOptions& options = {});

  private:
    class Search;
    const Index& index_of(Facts& facts, const Step& step);

    // The tables at catoms in which searches look for facts that agree with what is known: those that were looked through several times
    // have an index.
    struct Tables {
        struct Table {
            u32 scans = 0;
            std::unique_ptr<Index> index = {};
        };
        Facts* facts;
        Source source;
        std::vector<std::size_t> key;
        std::unordered_map<u64, Table> by_catom = {};
    };
    // Null: no table of these facts has been looked through yet that is long enough.
    Tables* tables_of(const Facts& facts, const Step& step, const std::vector<std::size_t>& key);
    const Index* index_at(const Facts& facts, const Step& step, const std::vector<std::size_t>& key, u64 catom);
    void note_scan(Facts& facts, const Step& step, const std::vector<std::size_t>& key, u64 catom);
    std::vector<check::Type> types_of(const Step& step) const;

    const Program& program_;
    Facts& facts_;
    Terms& terms_;
    struct IndexOf {
        Facts* facts;
        std::unique_ptr<Index> index;
    };
    std::vector<IndexOf> indexes_;
    std::vector<Tables> tables_;
    std::size_t table_rows_ = 0;  // In all their indexes.
};

}  // namespace meld::inspect
