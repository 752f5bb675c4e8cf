// Rule plans: how each rule is evaluated at its execution site, and how each predicate is stored. Printed by --emit=plan in
// the concrete syntax shown beside each step.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/check/program/program.h"
#include "compiler/plan/heads.h"
#include "runtime/base/assert.h"
#include "runtime/module/abi/storage_abi.h"

namespace meld::plan {

// ---- storage

enum class Storage { Unused, Flag, Single, PerLink, Rows, World };
std::string storage_name(Storage storage);

struct Column;
using ColumnId = Id<Column>;

struct Field {  // One argument after the catom.
    check::Type type = check::Type::Int;
    std::uint32_t bytes = 8;
    std::uint32_t offset = 0;  // In the record or row; PerLink: of port 0.
};

struct Stored {
    Storage storage = Storage::Unused;
    bool used = false;  // Some rule mentions it, or the program declares it. An action that only linear rules request is not stored.
    ColumnId column;
    std::vector<Field> fields;
    bool exported = false;  // Read at neighbours.
    bool ranked = false;    // Carries the rank of its fact.
    std::uint32_t rank_offset = 0;
    bool waits = false;  // Its candidates carry the ports of the neighbours they come from.
    std::uint32_t from_offset = 0;
    std::uint32_t presence_offset = 0;  // Unranked Flag and Single: a byte; PerLink: the mask of ports.
    std::uint32_t presence_mask = 0;
    PredicateId base;  // The predicate that stores facts given from outside: itself, an auxiliary, or none.
};

struct Column {
    std::string name;
    bool rows = false;
    bool exported = false;
    std::vector<PredicateId> predicates;
    std::uint32_t stride = 0;  // Bytes a catom.
    std::uint32_t row_bytes = 0;
    std::uint64_t own_dirty = 0;
    std::uint64_t reader_dirty = 0;
    bool follows_rows = false;  // Its changes are recorded by row, for readers that evaluate delta rules.
};

// ---- rules: steps, outermost first; each later step runs for every way to satisfy the earlier ones

// Whether a linear rule that updates one fact, the state, by each fact of another predicate, the messages, may take all messages in one
// sweep (sweep.cpp).
struct Sweep {
    PredicateId state = {}, messages = {};
    std::string obstacle = {};  // Why not; empty: it may.

    bool candidate() const { return state.valid(); }
    bool applies() const { return candidate() && obstacle.empty(); }
};

// Whether a linear rule does all its firings in one search, which goes on from match to match instead of starting over (one_search.cpp).
struct OneSearch {
    static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
    struct MadeAgain {
        std::size_t step = kNone, head = kNone;  // The match that consumes a fact, and the head that makes it again.
    };
    bool asked = false;                    // Whether the rule consumes facts.
    std::string obstacle = {};             // Why it starts over after each firing; empty: it does not, if it was asked.
    std::vector<MadeAgain> put_back = {};  // Facts that are consumed and made again as they were.
    MadeAgain changed = {};                // The fact that is made again with other arguments, if any.

    bool applies() const { return asked && obstacle.empty(); }
};

struct RulePlan {
    RuleId rule;
    std::vector<Step> steps;
    std::vector<HeadPlan> heads;
    std::uint64_t inputs = 0;  // Dirty bits after which the rule is evaluated again.
    std::uint64_t absent = 0;  // For a linear rule: the bits of linear facts that must be absent, or are counted.
    Sweep sweep = {};
    OneSearch search = {};
    // For a delta rule (deltas.cpp):
    std::vector<VariableId> given = {};  // The head's group, known from the start.
    std::uint64_t unchanged = 0;         // The delta rule does not apply if one of these inputs has changed too.
    // For rules that begin alike (share.cpp): these continue after the steps, in the variables of `rule` and, numbered after them, `more`.
    // They have the heads.
    std::vector<RulePlan> branches = {};
    std::vector<check::Variable> more = {};

    // The fact that a view derives, its one head.
    const MakeFact& derived() const {
        MELD_EXPECT(heads.size() == 1 && as<MakeFact>(heads[0]) != nullptr, "a view with {} heads", heads.size());
        return *as<MakeFact>(heads[0]);
    }
};

// How a predicate with many rows is evaluated if only single rows of its inputs have changed: `affected` finds the groups that the changed
// rows of one input can affect, `regroup` contains the rules again, for one known group.
struct DeltaRules {
    std::uint64_t inputs = 0;  // If anything else has changed, all groups are evaluated; 0: always.
    std::vector<RulePlan> affected = {};
    std::vector<RulePlan> whole = {};  // The rules that these are made of, in the same order, before rules share steps.
    std::vector<RulePlan> regroup = {};
};

// How the support of recursive predicates is maintained (docs/design.md, "Recursion").
enum class Recursion { None, LocalSets, Ranked, Mutual, Tree, Rounds };
std::string recursion_name(Recursion recursion);

// How a stratum of the program is evaluated.
struct StratumPlan {
    std::vector<PredicateId> predicates;
    std::vector<RulePlan> rules;
    Recursion recursion = Recursion::None;
    bool links = false;
    std::uint64_t inputs = 0;
    std::uint64_t outputs = 0;  // own_dirty of its columns.
    DeltaRules deltas = {};
    // LocalSets: semi-naive evaluation. Derives from the rows that the last round has derived, with one rule for each atom.
    std::vector<RulePlan> semi_naive = {};

    // Whether the rules of this stratum see the rows of a predicate as they are derived, round by round, and not in order.
    bool grows(PredicateId p) const {
        return !semi_naive.empty() && std::find(predicates.begin(), predicates.end(), p) != predicates.end();
    }
};

// The linear predicates of which a catom mostly holds one fact at a time, which is then a variable of the module, and those of the messages
// that are taken in one pass (singles.cpp).
struct Singles {
    std::vector<PredicateId> facts = {}, messages = {};
    std::string obstacle = {};  // Why facts are always in lists; empty: they are not, if there are any linear rules.

    bool apply() const { return !facts.empty(); }
};

struct Plan {
    check::Program program;      // With the auxiliaries of localization.
    std::vector<Stored> stored;  // By PredicateId.
    Table<Column> columns;
    std::vector<StratumPlan> strata;      // In the order of evaluation.
    std::vector<RulePlan> linear_rules;   // In order of priority.
    std::vector<RulePlan> initial_facts;  // Linear axioms, given once to every new catom.
    Singles singles;
    std::vector<PredicateId> pulled;  // Linear predicates that catoms tell all their neighbours alike, who may read them there (pull.cpp).
    bool reads_tick = false;
    bool idle_births = false;  // As in ModuleInfo.
    bool counts = false;       // The module is to count what its rules do.
    bool places = false;       // It is to say at any time which rule runs; so does one that counts.
    // By RuleId, if the module is compiled in pieces (compiler/emit/emit.h), which do not change where lines, and rules of other
    // heads, come and go: the names of their functions. Otherwise empty.
    std::vector<std::string> stable_names;
    bool checked = false;  // Its code is to check what it takes for granted (runtime/module/kernel/check.h).

    bool in_pieces() const { return !stable_names.empty(); }
    // A long module in pieces keeps to rows.
    bool pulls(PredicateId p) const { return !in_pieces() && std::find(pulled.begin(), pulled.end(), p) != pulled.end(); }
    const Stored& of(PredicateId p) const {
        MELD_EXPECT(p.valid() && p.index() < stored.size(), "predicate {} of {}", p.index(), stored.size());
        return stored[p.index()];
    }
    const Column& column_of(PredicateId p) const {
        MELD_EXPECT(of(p).column.valid(), "{} has no column", program.predicates[p].name);
        return columns[of(p).column];
    }
};

struct PlanOptions {
    std::vector<std::string> without = {};                                // Passes to skip; only optimizing passes can be skipped.
    std::string after = {};                                               // The last pass; empty: all.
    bool counts = false, places = false, links = false, checked = false;  // As in Plan.
};

// Plans a program that was checked without errors.
Plan make_plan(check::Program program, const PlanOptions& options = {});
// The names of the passes in order: all, or those that can be skipped.
enum class Passes { All, Optional };
std::vector<std::string_view> passes(Passes which);

// ---- the passes, one file each, in this order

// Replaces variables and operators by the literals they are known to equal.
void fold_constants(check::Program& program);
// Drops rules that can never fire.
void drop_dead_rules(check::Program& program);
// Then those of compiler/desugar/desugar.h: `delay`, `relay`, `undelivered`, `watch`, `wait`.

// Gives predicates that are derived by both rules and linear heads an auxiliary that stores the given facts.
void separate_base(check::Program& program);
// Lets recursive rules that test whether a min or max has a value read a view of the groups instead.
void ask_for_existence(check::Program& program);
// Keeps all derivations that no other one beats, if values of a min or max may follow from those they replace.
void keep_fronts(check::Program& program);
// Splits rules over several links into auxiliaries that neighbours export, so that every rule reads over at most one link.
void localize(check::Program& program);
// Computes the least or greatest of a neighbour's rows there, so that one value is sent instead of all of them.
void push_aggregates(check::Program& program);
// Lets rules with equal remote parts share one auxiliary.
void merge_auxiliaries(check::Program& program);
// Replaces many consecutive facts by one rule and a table.
void gather_facts(check::Program& program);
// Finds bounds of the ints in derived facts.
void narrow_integers(check::Program& program);
// Finds the strongly connected components of predicates in the order of evaluation, and splits those that recur along a tree.
void find_strata(check::Program& program);
// Finds bounds of the ints that grow with the ranks of their facts.
void narrow_ranked(check::Program& program);
// Chooses storage, records and columns, and dirty bits.
void lay_out(Plan& plan);
// Orders the bodies into steps.
void order_rules(Plan& plan);
// Finds the strata that can be evaluated by row, with their delta rules.
void plan_deltas(Plan& plan);
// Finds the linear rules that take many facts in one sweep.
void plan_sweeps(Plan& plan);
// Finds the linear rules that fire again and again in one search.
void plan_searches(Plan& plan);
// Finds whether linear facts may be variables while a catom holds one of each.
void find_singles(Plan& plan);
void find_letters(Plan& plan);
// Finds the linear facts that receivers may read where their senders have written them.
void find_pulled(Plan& plan);
// Finds whether a catom without facts has nothing to do when it is born.
void find_idle_births(Plan& plan);
// Lets rules of one predicate that begin with the same steps share them.
void share_prefixes(Plan& plan);
// Chooses how each match finds its facts: by their order, with an index, or one after the other.
void choose_indexes(Plan& plan);
// ---- parts of passes

// The strongly connected components of the program's predicates, in order. The program must be stratifiable.
void find_strongly_connected(check::Program& program);
// Splits strata that recur along a tree: the part that a catom's rules read at the catom itself comes first.
void split_trees(check::Program& program);

// Whether the rules of a stratum may derive ever more facts: they derive a group from a value that they compute, and depend on each other.
// Otherwise all that they derive is made of what there is.
bool may_grow(const Plan& plan, const StratumPlan& stratum);
// Whether the predicate is derived by such rules.
bool may_grow(const Plan& plan, PredicateId predicate);

// Whether an atom names a link of its catom, as a route does: its first argument after the catom is a variable.
inline bool is_route(const check::Program& program, const check::Atom& a) {
    return program.predicates[a.predicate].route && a.arguments.size() > 1 && a.arguments[1].is_variable();
}

// Whether the facts of a stratum have ranks (docs/design.md, "Ranks and quarantine"). Its trees must have been split.
bool has_ranks(const check::Program& program, const check::Stratum& stratum);

// How many arguments after the catom form the group: all those before an aggregated one.
inline std::size_t group_arguments(const check::Predicate& p) {
    return (p.aggregate == check::Aggregate::None ? p.arguments.size() : p.aggregate_at) - 1;
}

// The rule with all variables that its plan mentions.
check::Rule rule_of(const Plan& plan, const RulePlan& rule);

std::string print(const Plan& plan);
// For every rule, where it runs, in which order it reads and why, and what it sends; for every predicate, its storage and bytes a catom.
std::string explain(const Plan& plan);
// Bytes a catom of all columns, without what rows need beyond their heads.
std::uint64_t bytes_per_catom(const Plan& plan);
// The linear fact of the prelude by which amoebots are activated, if the program reads it in the links form. Storage must be chosen.
std::optional<check::PredicateId> activated_fact(const Plan& plan);

}  // namespace meld::plan
