// Rule plans: how each rule is evaluated at its home catom, and how each predicate is stored. Printed by --emit=plan in
// the concrete syntax shown beside each step.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/check/program.h"

namespace meld::plan {

using check::PredicateId;
using check::RuleId;
using check::Term;
using check::VariableId;

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
    bool used = false;  // Some rule mentions it, or it is the program's own. An action that only linear rules ask for is not stored.
    ColumnId column;
    std::vector<Field> fields;
    bool exported = false;  // Read at neighbours.
    bool ranked = false;    // Carries the rank of its fact.
    std::uint32_t rank_offset = 0;
    bool waits = false;  // Its candidates carry the ports of the neighbours they come from.
    std::uint32_t from_offset = 0;
    std::uint32_t presence_offset = 0;  // Unranked Flag and Single: a word; PerLink: the mask of ports.
    std::uint32_t presence_mask = 0;
    PredicateId base;  // Where facts given from outside go: itself, an auxiliary, or none.
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
    bool follows_rows = false;  // Readers are told which rows have changed.
};

// ---- steps of a rule, outermost first; each later step runs for every way to satisfy the earlier ones

enum class ArgumentUse { Skip, Bind, Compare };

// Why a step reads at this point and not earlier or later. For --explain-rules alone.
enum class Reason {
    Written,   // Where the rule has it: linear rules mean this order.
    Test,      // All arguments are known.
    Exists,    // Gives no variable a value.
    One,       // One fact at most.
    Rows,      // Several facts, more the fewer arguments are known.
    Elements,  // Those of a list or set that is known.
    Named,     // A neighbour whose number is known.
    Links,     // Each neighbour.
};
struct Choice {
    Reason reason = Reason::Written;
    std::size_t known = 0;  // Rows: how many arguments after the catom are known.
    // Those that the rule has before it: not valid stands for the elements of a list or set.
    std::vector<PredicateId> dearer = {};
    std::vector<PredicateId> waiting = {};  // They need what is not known yet.
};

struct Step {
    enum class Kind {
        Neighbours,  // for each neighbour B [at port P]
        Locate,      // find neighbour B              B's id is known
        Match,       // dist(A, D)                    facts of a stored or world predicate at a place
        Test,        // if D > 3
        Set,         // D = X + 1
        Absent,      // unless { steps }
        Each,        // for each E in L
        Fold,        // S = sum X over { steps }
        Delta,       // if delta X of p(A, X) > e     the fact has been matched; compares with what held before the tick
    } kind = Kind::Match;
    VariableId place = {};             // Neighbours, Locate: the catom found; Match: where.
    bool at_home = true;               // Match: at the rule's home.
    PredicateId predicate = {};        // Match
    std::vector<Term> arguments = {};  // Match, after the catom.
    std::vector<ArgumentUse> uses = {};
    VariableId port = {};                                 // Neighbours: bound to the port, if valid.
    Term port_compare = {};                               // Neighbours: the port must equal this (where not Anonymous).
    bool port_from_other_side = false;                    // The port is the one at which B sees the home.
    bool read_only = false;                               // Match of a linear fact that is left in place.
    bool ranks = false;                                   // Match: its rank counts for the head's.
    bool changed = false;                                 // Match: only rows that have changed, as they were and as they are.
    Term term = {};                                       // Test, Set; Each: the list; Fold: the value of one match; Delta: the bound
    VariableId variable = {};                             // Set, Each, Fold, Delta
    VariableId position = {};                             // Each: which element it is, if valid.
    std::vector<Step> inner = {};                         // Absent, Fold
    check::Aggregate aggregate = check::Aggregate::None;  // Fold
    check::FunctionId fold = {};                          // Fold, Custom
    Term initial = {};                                    // Fold, Custom: what it starts from, if not the first match
    check::Op compare = check::Op::Greater;               // Delta
    Choice choice = {};                                   // Neighbours, Locate, Match, Each
};

struct HeadPlan {
    check::Head::Kind kind = check::Head::Kind::Fact;
    PredicateId predicate;
    VariableId place;
    std::vector<Term> arguments = {};
    std::vector<VariableId> contributors = {};  // As of the rule.
    std::vector<Step> steps = {};               // Comprehension, Aggregate
    std::vector<HeadPlan> heads = {};
    std::vector<HeadPlan> others = {};    // Aggregate: after all matches; If: else
    std::vector<check::Fold> folds = {};  // Aggregate
    Term term = {};                       // If: the condition; Set: the value
    VariableId variable = {};             // Set
};

struct RulePlan {
    RuleId rule;
    std::vector<Step> steps;
    std::vector<HeadPlan> heads;
    std::uint64_t inputs = 0;  // Dirty bits after which the rule is looked at again.
    std::uint64_t absent = 0;  // Of a linear rule: the bits of linear facts that must not be there, or are counted.
    // Of a delta (deltas.cpp):
    std::vector<VariableId> given = {};  // The head's group, known from the start.
    std::uint64_t unchanged = 0;         // Of no use where one of these inputs has changed too.
    // Of rules that begin alike (share.cpp): these go on where the steps end, in the variables of `rule` and, numbered after
    // them, `more`. The heads are theirs.
    std::vector<RulePlan> branches = {};
    std::vector<check::Variable> more = {};
};

// How a predicate with many rows is settled where only rows have changed: `touches` find the groups that changed rows of
// one input can affect, `groups` are the rules once more, for one group that is known.
// Where recursion stays at one catom, `touches` derive what follows from rows that the last round has made.
struct Deltas {
    std::uint64_t inputs = 0;  // Where anything else has changed, all is settled; 0: always.
    std::vector<RulePlan> touches;
    std::vector<RulePlan> groups;
};

// How the support of a strongly connected component is maintained (docs/design.md, "Recursion").
enum class Recursion { None, LocalSets, Ranked, Mutual, Tree };
std::string recursion_name(Recursion recursion);

struct ComponentPlan {
    std::vector<PredicateId> predicates;
    std::vector<RulePlan> rules;
    Recursion recursion = Recursion::None;
    bool links = false;
    std::uint64_t inputs = 0;
    std::uint64_t outputs = 0;  // own_dirty of its columns.
    Deltas deltas = {};
};

struct Plan {
    check::Program program;      // With the auxiliaries of localization.
    std::vector<Stored> stored;  // By PredicateId.
    Table<Column> columns;
    std::vector<ComponentPlan> components;
    std::vector<RulePlan> linear_rules;  // In order of priority.
    std::vector<RulePlan> births;        // Linear axioms.
    bool reads_tick = false;

    const Stored& of(PredicateId p) const { return stored[p.index()]; }
};

struct PlanOptions {
    std::vector<std::string> without = {};  // Passes that are left out; only those that make programs cheaper can be.
    std::string after = {};                 // The last pass; empty: all.
};

// Plans a program that was checked without errors.
Plan make_plan(check::Program program, const PlanOptions& options = {});
// The names of the passes in order: all, or those that can be left out.
enum class Passes { All, Optional };
std::vector<std::string_view> passes(Passes which);

// ---- the passes, one file each, in this order

// Replaces variables and operators by the literals they are known to be.
void fold_constants(check::Program& program);
// Leaves out rules that can never fire.
void drop_dead_rules(check::Program& program);
// Rewrites facts for later to auxiliaries in which they wait, and rules that end the wait.
void delay_heads(check::Program& program);
// Rewrites facts for catoms more than one link away to auxiliaries that are handed on.
void relay_heads(check::Program& program);
// Lets facts whose way is gone come back, where the program declares that they do.
void return_undelivered(check::Program& program);
// Gives facts whose change is looked at a view that can be compared with what it was.
void watch_changes(check::Program& program);
// Gives aggregates that wait for neighbours over links of the program's own a view of the neighbours they wait for.
void wait_for_neighbours(check::Program& program);
// Gives predicates that both rules and linear heads feed an auxiliary that stores what was given.
void separate_base(check::Program& program);
// Lets recursive rules that ask whether a min or max has a value ask a view of the groups instead.
void ask_for_existence(check::Program& program);
// Splits rules over several links into auxiliaries that neighbours export, so that every rule reads one link at most.
void localize(check::Program& program);
// Takes the least or greatest of a neighbour's rows there, so that one value is sent instead of them.
void push_aggregates(check::Program& program);
// Lets rules whose far parts are alike share one auxiliary.
void merge_auxiliaries(check::Program& program);
// Orders components that recur along a tree: what a catom's rules read at the catom itself comes first.
void split_trees(check::Program& program);
// Makes one rule and a table of many facts in a row.
void gather_facts(check::Program& program);
// Finds between which values the ints of derived facts lie.
void narrow_integers(check::Program& program);
// Chooses storage, records and columns, and dirty bits.
void lay_out(Plan& plan);
// Orders the bodies into steps.
void order_rules(Plan& plan);
// Finds the components that can be settled row by row, and how.
void plan_deltas(Plan& plan);
// Lets rules of one predicate that begin with the same steps take them together.
void share_prefixes(Plan& plan);
// Run after every pass: what later ones and emission rely on. A violation is our bug and ends the process.
void verify(const check::Program& program);
void verify(const Plan& plan);

// How many arguments after the catom make the group: all that stand before an aggregated one.
inline std::size_t group_arguments(const check::Predicate& p) {
    return (p.aggregate == check::Aggregate::None ? p.arguments.size() : p.aggregate_at) - 1;
}

// The rule with all variables that its plan mentions.
check::Rule rule_of(const Plan& plan, const RulePlan& rule);

std::string print(const Plan& plan);
// For every rule where it runs, in which order it reads and why, and what it sends; for every predicate its storage and bytes a catom.
std::string explain(const Plan& plan);
// Bytes a catom of all columns, without what rows need beyond their heads.
std::uint64_t bytes_per_catom(const Plan& plan);

inline constexpr std::uint32_t kMaxPorts = 12;

}  // namespace meld::plan
