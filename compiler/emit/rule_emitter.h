// Emits one rule: nested loops over the plan's steps, with the heads innermost. The state that the emitting files share: rules.cpp (the
// rule, links), matches.cpp (facts), lookups.cpp (how rows are found), heads.cpp (aggregates, heads), sweep.cpp (all messages in one pass),
// one_search.cpp (all firings in one search).
#pragma once

#include <map>
#include <optional>

#include "compiler/emit/writer.h"

namespace meld::emit {

using namespace check;
using plan::ArgumentUse;
using plan::as;
using plan::HeadPlan;
using plan::MakeFact;
using plan::Match;
using plan::Step;

class RuleEmitter {
  public:
    RuleEmitter(const plan::Plan& plan, const RulePlan& rule, Writer& w)
        : plan_(plan),
          rule_plan_(rule),
          w_(w),
          joined_(rule.more.empty() ? std::nullopt : std::optional(plan::rule_of(plan, rule))),
          scope_{plan, joined_ ? *joined_ : plan.program.rules[rule.rule], rule.rule.index()} {
        scope_.places.insert(scope_.rule.site);
    }
    void view();
    // `marks`: it notes what it makes and consumes (marks.h).
    void linear(bool marks);
    // The same for a catom with at most one fact of each predicate (singles.cpp).
    void single();
    // What a rule derives from the fact of one neighbour alone (concerned.cpp).
    void offer();
    // A delta rule: the groups of the head that changed rows of one input can affect. `offer`: the rule itself, if what it derives from the
    // row alone tells whether the group is affected; or null.
    void affected(std::size_t number, const RulePlan* offer);
    // What the rule derives from the rows that neighbours have gained, if all of it follows from one row of a neighbour.
    void gains(std::size_t number);
    // The rule for one group of the head.
    void group();
    // A semi-naive rule: derives from rows that the last round has derived.
    void semi_naive(std::size_t number);

  private:
    // A linear fact that an atom has matched.
    struct Matched {
        PredicateId predicate;
        std::string position;  // The C++ name of the index into the bag.
    };

    // A selector reads all matches first, and then the chosen one again.
    void choose();
    // In a module with counters: counts the derivations of the rest of the block, and for the whole rule its evaluation.
    enum class Part { Whole, Branch };
    void count(plan::RuleId rule, Part part);
    void count_evaluation(plan::RuleId rule);
    // A linear rule is about to be applied: it is counted, and whoever wants to know is told with which values.
    void about_to_fire();
    void tell_firing();
    // ---- a linear rule that takes all messages of a catom (sweep.cpp)
    void sweep();
    void match_in_sweep(const Match& s);
    void next_state(const MakeFact& h);
    // ---- a linear rule that does all its firings in one search (one_search.cpp)
    void all_firings();
    void fire_in_search();
    void end_search(const std::vector<PredicateId>& read);
    // `name` is that of the predicate.
    void each_in_search(const Match& s, const std::string& i, const std::string& name);
    const Match& search_match(std::size_t step) const { return *as<Match>(rule_plan_.steps[step]); }
    // What becomes of the fact that a match finds, and whether some facts of a predicate are taken.
    bool puts_back(const Match& s) const;
    bool changes(const Match& s) const;
    bool takes(const Match& s) const;
    bool takes_from(PredicateId p) const;
    const Match& goes_on_at() const;
    // ---- a linear rule whose facts are variables (singles.cpp)
    void sweep_single();
    void find_sums();
    void match_single(const Match& s);
    void need_room();
    // Ends a block: what it has bound is unknown outside.
    void restore(const Scope& before);
    void comment(const check::Rule& rule);
    // The parts of rules with the same beginning, one after the other.
    void branches();
    // Comprehensions see the facts from when the rule was applied, minus those consumed since: facts that the rule itself produces join the
    // bags when it is done, and given facts are read as they were.
    void freeze();
    void close_to(std::size_t depth);
    // For a view: the same condition, false if computing it failed.
    std::string defined(const std::string& condition, bool fails) const {
        return leaves_out_ && fails ? fmt::format("defined(*s.e, {})", condition) : condition;
    }
    // For a view: the following code runs only if nothing has failed so far.
    void only_if_defined(bool fails) {
        if (leaves_out_ && fails) w_.open("if (defined(*s.e)) {");
    }
    std::string fresh(const char* stem) { return fmt::format("{}{}", stem, scope_.next++); }
    void steps(const std::vector<Step>& all);
    void bind(VariableId v, const std::string& value);

    // ---- one function for each kind of step; each opens the block that contains the later steps
    void step(const plan::Test& s);
    void step(const plan::Set& s);
    void step(const plan::EachNeighbour& s);
    void step(const plan::FindNeighbour& s);
    void step(const Match& s);
    void step(const plan::Unless& s);
    void step(const plan::EachElement& s);
    void step(const plan::AggregateOver& s);
    void step(const plan::ChangeSince& s);

    void port_use(const plan::PortUse& use, const std::string& port);

    // ---- facts
    // Binds and compares the arguments of a match; value(i) is the C++ text of argument i, counted from 1.
    template <class Value>
    void use(const Match& s, const Value& value) {
        std::string conditions;
        bool fails = false;
        for (std::size_t i = 1; i <= s.arguments.size(); ++i) {
            const Term& t = s.arguments[i - 1];
            if (s.uses[i - 1] == ArgumentUse::Bind) {
                // The same variable twice in one fact: the second is a comparison with the first.
                bind(t.variable, value(i));
            } else if (s.uses[i - 1] == ArgumentUse::Compare) {
                const Type& type = plan_.program.predicates[s.predicate].arguments[i].type;
                fails = fails || plan::may_fail(plan_.program, t);
                conditions += (conditions.empty() ? "" : " && ") + equal(type, value(i), term_as(scope_, t, type));
            }
        }
        if (!conditions.empty()) w_.open(fmt::format("if ({}) {{", defined(conditions, fails)));
    }
    std::string row_type(PredicateId id) const { return predicate_name(plan_.program, id) + "_t::Row"; }
    // Whether all arguments of the group are compared, so that the row can be looked up.
    bool whole_key(const Match& s) const;
    static bool same_type(const Term& t, const Type& type) { return t.type == type; }
    // Emits the group row to look up; returns its name. fits_ becomes the condition that narrow fields can hold its values.
    std::string group_row(const Match& s);
    std::string fits_;
    // The same for some of its arguments, counted from 1, without the condition that what is computed is defined.
    std::string known_row(const Match& s, const std::vector<std::size_t>& arguments);
    void match_here(const Match& s);
    // Whether the rule is of a stratum that derives the predicate in rounds.
    bool grows(PredicateId p) const;
    // A PerLink fact names its neighbour by port.
    void match_link(const Match& s, const std::string& f);
    void match_remote(const Match& s);
    // Rows that have changed, both old and new: of a predicate derived here in this evaluation, or since the last one.
    void match_changed(const Match& s);
    // Opens loops over changed rows: one over those that differ in what the body reads, and, where the head is made, one over those that
    // are like the one of the first loop.
    void each_kind(const Match& s);
    void each_of_kind(const Match& s);
    void match_bag(const Match& s);
    // Whether the rule consumes the linear fact that the match finds.
    bool consumes(const Match& s) const { return !s.read_only && !asking_; }
    // Notes which fact of a bag it finds, which must be another one than those before, if the rule consumes one of the two.
    void claim(const Match& s, const std::string& position);
    // Opens the loop over the rows of a match; `i` names the position (lookups.cpp).
    void each_row(const Match& s, const std::string& i, const std::string& rows, const std::string& count);
    bool by_all_but_last(const Match& s) const;
    void each_but_last(const Match& s, const std::string& row);
    // The name of the struct that describes how the rows of a match are found.
    std::string search_type(const Match& s) const;
    // The indexes of bags that a linear rule looks into.
    void declare_indexes();
    std::string each_place(const Match& s);
    // The site of the catom's cell. In the links form most catoms never ask for it.
    std::string own_cell() const { return plan_.program.by_links ? "s.g->catom_site[s.catom]" : "s.site"; }
    void match_world(const Match& s, WorldSource source);

    // ---- aggregates of matches, in bodies and heads
    struct Accumulator {
        Aggregate aggregate;
        std::string made, seen;  // C++ names: the object that computes the result, or the result (Custom), and the number of matches.
        Type type;
        FunctionId function = {};  // Custom: folds the values, starting from the first if there is no initial one.
        bool initial = false;      // Custom: it starts from the parameter.

        // Whether it has no value if nothing matches.
        bool needs_match() const { return info(aggregate).of_nothing.empty() && !initial; }
    };
    Accumulator start_accumulator(Aggregate aggregate, const Type& type, FunctionId function, const Term& parameter);
    // The type that the value of one match is converted to.
    Type accumulated_type(const Accumulator& f) const;
    // Adds one match.
    void accumulate(const Accumulator& f, const std::string& value);
    // The result over all matches.
    std::string accumulated(const Accumulator& f) const;

    // ---- heads
    std::string head_value(PredicateId id, std::size_t argument, const Term& t);
    // Emits `Row row;` and its fields.
    void make_row(const MakeFact& h);
    void propose(const MakeFact& h);
    // For a row of an aggregate that waits: the ports of the neighbours it comes from.
    void heard_from(const MakeFact& h);
    void consume();
    void raise(PredicateId id) {
        if (marks_) w_.line("s.raised |= {};", own_bit(id));
    }
    // Consuming facts enables no rule that could not fire before, except one that tests for their absence.
    void lower(PredicateId id) {
        if (marks_) w_.line("s.lowered |= {};", own_bit(id));
    }
    std::string own_bit(PredicateId id) const { return hex(plan_.columns[plan_.of(id).column].own_dirty); }
    void heads(const std::vector<HeadPlan>& all);
    void head_block(const HeadPlan& h);
    void head(const MakeFact& h);
    void head(const plan::ForAll& h);
    // The results are computed while the matches are consumed, and then the last heads are produced once.
    void head(const plan::AggregateAll& h);
    void head(const plan::Choose& h);
    void head(const plan::With& h);
    void values(const MakeFact& h);
    void send(const MakeFact& h);
    bool sent_as_row(const MakeFact& h) const;
    std::string send_to(const MakeFact& h, const std::string& to) const;
    // In a module with counters, after the fact in `values` has been sent over this port.
    void count_sent(const MakeFact& h, const std::string& port);
    bool consumes(const plan::ForAll& h) const;
    // Before a comprehension whose heads may consume what it reads: it goes on with the facts as they were.
    void copy_bags(const plan::ForAll& h);
    // What these heads compute from what is known already is computed at most once (invariants.cpp).
    void keep_invariants(const std::vector<HeadPlan>& heads);
    void keep_invariant(const Term& t);
    bool is_invariant(const Term& term) const;
    // The same for facts that go to many alike, each written once.
    void open_letters(const std::vector<HeadPlan>& heads);
    // The heads of every match, which also feed the aggregates; `made` has an accumulator for each.
    void comprehension(const plan::ForAll& h, const std::vector<HeadAggregate>& aggregates, const std::vector<Accumulator>& made);
    void accumulate_match(const std::vector<HeadAggregate>& aggregates, const std::vector<Accumulator>& made);

    const plan::Plan& plan_;
    const RulePlan& rule_plan_;
    Writer& w_;
    std::optional<check::Rule> joined_;  // For rules that begin alike: the first rule with the variables of all.
    Scope scope_;
    // What the body has matched so far. No fact is in both: that of `$p(...)` is left where it is.
    std::vector<Matched> consumed_, kept_;
    bool whether_ = false;  // Within a negation: it does not matter in how many ways.
    bool asking_ = false;   // Within a negation or an aggregate: it sees all linear facts, and consumes and keeps none.
    // Derivations that fail are left out: in views, except where all matches are read at once, and except in rules for single rows, where a
    // failure means that all rules are to be evaluated.
    bool leaves_out_ = false;
    bool sweeping_ = false;                                       // Within sweep().
    bool single_ = false;                                         // Within single().
    std::vector<std::size_t> sums_;                               // See find_sums().
    const Match* searching_ = nullptr;                            // Within all_firings(): where the search goes on after a firing.
    std::vector<std::pair<const Match*, std::string>> found_at_;  // Consumed facts of such a search, and their positions,
    std::string goes_on_;                                         // and the statements that go on with it after a firing.
    std::map<const Match*, std::string> bag_indexes_;             // C++ names.
    bool marks_ = false;                                          // As for linear().
    struct Changed {
        std::string row, gone;  // C++: the row, and whether it holds no longer.
    };
    Changed last_changed_;
    struct Alike {
        std::string rows, first, end;  // C++ names.
    };
    Alike alike_;  // Of each_kind().
    // Facts that a comprehension sends to many alike: the C++ name of a Letter.
    std::map<const MakeFact*, std::string> letters_;
    PredicateId near_;                        // That of the group which is derived, if the function knows where it is: a parameter `near`.
    std::vector<PredicateId> held_, frozen_;  // See freeze().
    struct Rows {
        std::string rows, count;  // C++ names.
    };
    std::map<PredicateId, Rows> copied_;  // See copy_bags().
};

}  // namespace meld::emit
