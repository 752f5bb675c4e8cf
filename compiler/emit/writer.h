// Shared by the emitting files: indented text, names, and the scope of a rule being emitted.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "compiler/plan/join/may_fail.h"
#include "compiler/plan/plan.h"
#include "runtime/base/assert.h"

namespace meld::emit {

using plan::PredicateId;
using plan::RulePlan;
using plan::Storage;
using plan::Stored;

// Where in a text a part of the module begins that may be compiled by itself; the same part may go on later.
struct PartBegin {
    std::size_t at;
    std::string name;
};

class Writer {
  public:
    // In pieces: part() counts.
    explicit Writer(bool in_pieces = false) : in_pieces_(in_pieces) {}

    template <class... A>
    void line(fmt::format_string<A...> format, A&&... a) {
        raw(fmt::format(format, std::forward<A>(a)...));
    }
    void raw(const std::string& text) {
        if (!text.empty()) out_.append(std::min(depth_, kMaxIndent) * 4, ' ');
        out_ += text;
        out_ += '\n';
    }
    // The lines of a text, indented further.
    void lines(const std::string& text) {
        for (std::size_t from = 0, to; from < text.size(); from = to + 1) {
            to = std::min(text.find('\n', from), text.size());
            raw(text.substr(from, to - from));
        }
    }
    // Lines that are indented already.
    void block(const std::string& text) { out_ += text; }
    void open(const std::string& text) {
        raw(text);
        ++depth_;
    }
    void close(const std::string& text = "}") {
        MELD_EXPECT(depth_ > 0, "no block is open at `{}`", text);
        --depth_;
        raw(text);
    }
    std::size_t depth() const { return depth_; }
    // What follows belongs to this part, and is in the module's namespace unless it belongs to the kernel. Without a name: all see it.
    enum class Where { Module, Kernel };
    void part(const std::string& name, Where where = Where::Module);
    void end_parts() { part(""), close_namespace(); }
    const std::vector<PartBegin>& parts() const { return parts_; }
    // The whole text, once every block is closed.
    const std::string& text() const {
        MELD_EXPECT(depth_ == 0, "{} blocks are open", depth_);
        return out_;
    }

  private:
    // Deeper blocks cannot be told apart by eye, and the spaces before them would grow with the square of the depth.
    static constexpr std::size_t kMaxIndent = 32;

    void close_namespace();

    std::string out_;
    std::size_t depth_ = 0;
    bool in_pieces_, in_namespace_ = false;
    std::vector<PartBegin> parts_;
};

// Parts of a module in pieces: what calls the others; what tells where rules are in the text, which changes with every line; and functions
// of the kernel. Parts of predicates have names with an arity.
inline const std::string kMainPart = "main", kTablesPart = "tables", kKernelPart = "(kernel)";
// The names of the numbers of rules begin so, with a capital as no other emitted name does.
inline const std::string kRuleNumber = "NumberOf_";

// Names of emitted things. All are lower-case with a number, so no Meld name can meet a C++ keyword or another one.
std::string clean(const std::string& name);                                 // letters, digits and _ only
std::string predicate_name(const check::Program& program, PredicateId id);  // dist_7
// The name of a predicate for comments and parts. Those that the compiler makes are named by lines too, which change with the text.
std::string name_without_line(const check::Predicate& predicate);
std::string record_name(plan::ColumnId id);                          // record_2
std::string rule_function(const plan::Plan& plan, plan::RuleId id);  // dist_at_line_12_r3
// The number of a rule as a C++ expression.
std::string rule_number(const plan::Plan& plan, plan::RuleId id);
// Before what another part of the module uses: `static ` unless it is compiled in pieces.
const char* shared(const plan::Plan& plan);
// The same of constant tables.
const char* shared_table(const plan::Plan& plan);
// The part of the module that a predicate belongs to, with what derives it.
std::string part_of(const plan::Plan& plan, PredicateId id);
// The declaration of one of this many functions that are each called from few places: `static`, and if there are many, never inlined,
// because Clang takes more than proportionally longer for long functions.
const char* linkage(const plan::Plan& plan, std::size_t functions);
std::string cpp_type(const check::Type& type);  // i64 double bool u64
std::string field_name(std::size_t argument);   // a1: the first after the catom
std::string hex(std::uint64_t bits);            // 0x20ull
std::string quoted(const std::string& text);    // a C++ string literal

// What is known at a point of a rule: which variables have a C++ value, and which are places.
struct Scope {
    const plan::Plan& plan;
    const check::Rule& rule;
    std::size_t rule_index;
    std::set<plan::VariableId> values = {};
    std::set<plan::VariableId> places = {};
    int next = 0;                         // For fresh names.
    std::vector<std::string> ranks = {};  // Expressions for the ranks that count for the head.
    std::string caller = {};              // In a function: the C++ name of the rule that called it.
    // Terms of which the text is not to be made from their parts: they are computed once for several matches.
    std::map<const check::Term*, std::string> kept = {};
    std::string last_fact = {};  // The C++ name of the row that was matched last.

    std::string value(plan::VariableId v) const;  // D_4, or the id of a place.
    std::string at(plan::VariableId v) const;     // The catom index of a place.
    std::string port(plan::VariableId v) const;
    std::string local(plan::VariableId v) const;  // The C++ name of a variable.
    std::string site() const;                     // The rule that a trap names.
};

// The constant that holds the number of a type in kTypes: kType_list_int.
std::string type_symbol(const check::Type& type);
// The member of Value that holds a value of this type: integer, real, catom or list.
const char* value_member(const check::Type& type);
// A three-way comparison of two C++ expressions of this type, and whether they are equal.
std::string compared(const check::Type& type, const std::string& a, const std::string& b);
std::string equal(const check::Type& type, const std::string& a, const std::string& b);
// A hash of a C++ expression of this type: equal values have one.
std::string hashed(const check::Type& type, const std::string& value);
// A word from a C++ expression of this type, and the reverse.
std::string as_word(const std::string& value);
std::string from_word(const check::Type& type, const std::string& word);

// The word of a literal as static data. Appends declarations of the lists and strings in it to `before`, with names numbered from `number`.
std::string literal_word(const check::Term& t, const check::Type& type, std::string& before, int& number);

// The declaration of the kernel object of this name that aggregates values of this type: `SumOf<double> made0{}`. result: the type of the
// result; limit: a C++ expression for how many values the aggregate keeps, if it has such a parameter.
std::string aggregate_object(check::Aggregate aggregate, const check::Type& value, const check::Type& result, const std::string& limit,
                             const std::string& name);

// A term as a C++ expression of its type.
std::string term(const Scope& scope, const check::Term& t);
// The same, converted if the place is a float and the term an int.
std::string term_as(const Scope& scope, const check::Term& t, const check::Type& type);
// The same for a value in a list or a fact: NaN is not allowed.
std::string element(const Scope& scope, const check::Term& t, const check::Type& type);

// Declares a constant list or string as static data at namespace level; returns a pointer to it. `number` makes the names unique.
std::string static_list(const check::Term& t, int& number, Writer& w);

// In a module with counters: the bits of a message that tells a fact, as a C++ expression. word(i): that of its argument i, counted from 1.
std::string message_bits(const plan::Plan& plan, PredicateId id, const std::function<std::string(std::size_t)>& word);

// Of a match of `port`: whether it asks which amoebots are touched and whether they have two cells, but not over which ports.
bool asks_of_neighbours(const plan::Match& s);
// The statement that sets the rule which a failure message names, and which a profile finds.
std::string now_at(const plan::Plan& plan, const RulePlan& r);
// Tries the linear rules in order until one fires: statements that set `fired`, and end with a `break`. `fixed`: as fixed_marks(); `call`:
// what comes after the name of a rule's function; `stop`: a further condition to end.
void emit_tries(const plan::Plan& plan, bool fixed, const std::string& call, const std::string& stop, Writer& w);
// The structs that describe how rows are found by some of their arguments, whether there are any, and the indexes of a catom's views: the
// names of their types and members.
void emit_searches(const plan::Plan& plan, Writer& w);
bool has_lookups(const plan::Plan& plan);
void each_index_member(const plan::Plan& plan, const std::function<void(const std::string& type, const std::string& name)>& visit);
// Those of the sets that this stratum derives in rounds.
void each_rounds_index(const plan::Plan& plan, const plan::StratumPlan& stratum, const std::function<void(const std::string& name)>& visit);
// How many words have a bit for each linear rule.
inline std::size_t words_of_rules(const plan::Plan& plan) { return (plan.linear_rules.size() + 63) / 64; }
// The first rule that derives the predicate, which a trap names.
std::string first_rule(const plan::Plan& plan, PredicateId id);
// Whether a linear rule uses up all facts of the predicate, whatever else there is: `p(A, _) -o 1.` Then none is left when a catom has been
// evaluated, and there are some before only if they are what it is evaluated for: its row need not be read.
bool used_up(const plan::Plan& plan, PredicateId id);

// The predicate that is PredicateInfo::by_turn; not where facts are variables, which are read from rows.
std::optional<PredicateId> fact_by_turn(const plan::Plan& plan);

// A call of a function of the program.
std::string call(const Scope& scope, check::FunctionId id, const std::vector<check::Term>& operands);
// The same with arguments that are C++ expressions already.
std::string call_with(const Scope& scope, check::FunctionId id, const std::vector<std::string>& values);

// ---- the parts of a module, in order
void emit_types(const plan::Plan& plan, Writer& w);
void emit_records(const plan::Plan& plan, Writer& w);
// Returns the type that serves each predicate with a view.
std::map<PredicateId, std::string> emit_predicates(const plan::Plan& plan, Writer& w);
// The kernel's functions for these types, if the module is compiled in pieces: declared to all, and each type's in a part of its own.
void emit_kernels(const plan::Plan& plan, const std::map<PredicateId, std::string>& row_types, Writer& w);
// Whether the combination of the rows of a group needs the catom.
bool calls_catom(const plan::Plan& plan, PredicateId id);
void emit_self(const plan::Plan& plan, Writer& w);
void emit_load_and_save(const plan::Plan& plan, Writer& w);
void emit_externs(const plan::Plan& plan, Writer& w);
void emit_functions(const plan::Plan& plan, Writer& w);
// Whether the value of the constant is computed by the run and kept in Self, as the member constant_name() and the function NAME_value.
bool computed_once(const check::Constant& constant);
std::string constant_name(const check::Program& program, check::ConstantId id);
void emit_facts(const plan::Plan& plan, Writer& w);
void emit_view_rule(const plan::Plan& plan, const RulePlan& rule, Writer& w);
void emit_deltas(const plan::Plan& plan, const plan::StratumPlan& stratum, Writer& w);
// `marks`: it notes what it makes and consumes (marks.h).
void emit_linear_rule(const plan::Plan& plan, const RulePlan& rule, bool marks, Writer& w);
// The rules once more for catoms with at most one fact of each predicate, and evaluate_singles(), if the plan has them.
void emit_singles(const plan::Plan& plan, Writer& w);
void emit_strata(const plan::Plan& plan, Writer& w);
// The functions that report, before it is too late, which action or linear rule would read a derivation without a value.
void emit_stops(const plan::Plan& plan, Writer& w);
void emit_evaluate(const plan::Plan& plan, Writer& w);
void emit_schema(const plan::Plan& plan, Writer& w);

// The rules by which neighbours read a column, if the column can say whom a change concerns (ColumnInfo::concerned); else none.
// Whether a rule derives a fact of a predicate from each fact of the same predicate at a neighbour, and reads nothing else.
bool is_offer(const plan::Plan& plan, const plan::RulePlan& rule, PredicateId predicate);
// Whether a group of a stratum keeps its value unless what supports it goes or something better comes.
bool keeps_best(const plan::Plan& plan, const plan::StratumPlan& stratum);
// Whether delta rule `number` of a stratum follows a neighbour's row that alone tells what the rule derives from it.
bool is_delta_offer(const plan::Plan& plan, const plan::StratumPlan& stratum, std::size_t number);
// Whether all delta rules of a stratum do, so that rows which neighbours have gained are derived from at once (Gains in kernel/deltas.h).
bool takes_gains(const plan::Plan& plan, const plan::StratumPlan& stratum);
std::vector<const RulePlan*> offers_of(const plan::Plan& plan, plan::ColumnId column);
std::string concerned_function(plan::ColumnId column);
void emit_concerned(const plan::Plan& plan, Writer& w);
// For the parts of a module in pieces that name them.
void declare_concerned(const plan::Plan& plan, Writer& w);

// Whether some stratum has delta rules or is evaluated semi-naively.
bool has_deltas(const plan::Plan& plan);
// Whether some stratum keeps fronts.
bool keeps_fronts(const plan::Plan& plan);
// Whether the function that combines the rows of its groups calls a function of the program, or uses a constant of the run.
bool combines_at_catom(const check::Predicate& p);
// Whether the predicate has a working view (a Relation or a Bag) in Self.
bool has_view(const plan::Plan& plan, PredicateId id);
// Rows of at most so many bytes are copied in a few instructions.
inline constexpr std::uint32_t kShortRow = 32;
// Whether some argument of its facts points to a list.
bool has_lists(const plan::Stored& stored);

}  // namespace meld::emit
