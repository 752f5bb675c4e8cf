// Warnings of recursion that may not end: values that grow or improve through themselves, sums that feed themselves over links.
// Assumes check(); needs no program without errors.
#include <algorithm>
#include <map>

#include "compiler/check/analysis/fronts.h"
#include "compiler/check/analysis/rounds.h"
#include "compiler/check/program/values_read.h"
#include "compiler/lint/acyclic.h"
#include "compiler/lint/growth.h"
#include "compiler/lint/guarded.h"
#include "compiler/lint/inverted.h"
#include "compiler/lint/lint.h"
#include "compiler/lint/replaced.h"

namespace meld::lint {

using namespace check;
using diagnostics::Kind;

namespace {

constexpr const char* kGetWorse =
    "let values stay the same or get worse from catom to catom, or count the rounds in an argument before the aggregate";

class Recursion {
  public:
    Recursion(const Program& program, diagnostics::Reporter& report, Graph graph) : program_(program), report_(report), graph_(graph) {}

    void run() {
        for (const check::Stratum& c : program_.strata) warn(c);
    }

  private:
    void warn(const check::Stratum& c) {
        if (!c.recursive || (graph_ == Graph::Acyclic && ends_with_links(program_, c))) return;
        if (c.tree) {
            if (!c.feeds_itself && !c.rounds) warn_tree(c);
            return;
        }
        // If a bounded number of rounds is counted, no value leads to itself.
        if (count_rounds(program_, c) == Rounds::Bounded) return;
        if (!warn_growth(c) && !warn_improvement(c) && !warn_replaced(c) && !warn_not_monotone(c)) warn_inverted(c);
    }

    // A sum that feeds itself over links ends if these form a tree, or if its rounds are counted and bounded.
    void warn_tree(const check::Stratum& c) {
        const auto folding =
            std::find_if(c.predicates.begin(), c.predicates.end(), [&](PredicateId q) { return program_.predicates[q].needs_all(); });
        const PredicateId p = *folding;
        if (led_by_routes(c) || counts_up(c)) return;
        switch (count_rounds(program_, c)) {
            case Rounds::Bounded:
                return;
            case Rounds::Endless:
                report_
                    .add(Kind::UnboundedArithmetic, program_.predicates[p].span,
                         fmt::format("`{}` is computed in rounds, and no condition ends them", program_.predicates[p].name))
                    .help = "bound the number of the round, as in R < rounds";
                return;
            case Rounds::None:
                break;
        }
        report_
            .add(Kind::TreeRecursion, program_.predicates[p].span,
                 fmt::format("the {} `{}` feeds itself over links: it ends only where those links form a tree",
                             aggregate_name(program_, program_.predicates[p]), program_.predicates[p].name))
            .help = "use the links of a spanning tree, as examples/meld/census.meld does";
    }
    // Whether the neighbours' values are chosen among, not summed, and each rule tests a value from a neighbour against a bound. Where what
    // they came from is gone, such values count up to the bound, as the costs of ways do.
    bool counts_up(const check::Stratum& c) const {
        const auto chooses = [&](PredicateId q) {
            const Predicate& p = program_.predicates[q];
            if (!p.needs_all()) return true;
            if (p.aggregate != Aggregate::Custom) return false;
            if (!p.fold.valid()) return true;  // It was reported.
            const Function& f = program_.functions[p.fold];
            const auto parameter = [&](const Term& t) { return t.is_variable() && t.variable.index() < f.parameter_count; };
            return f.body.op == Op::If && parameter(f.body.operands[1]) && parameter(f.body.operands[2]);
        };
        const auto bounded = [&](const Rule& rule, const Atom& a) {
            const Predicate& p = program_.predicates[a.predicate];
            if (p.aggregate == Aggregate::None || !a.arguments[p.aggregate_at].is_variable()) return false;
            const VariableId value = a.arguments[p.aggregate_at].variable;
            return std::ranges::any_of(rule.body, [&](const Clause& clause) {
                if (clause.kind != Clause::Kind::Test || (clause.test.op != Op::Less && clause.test.op != Op::Greater)) return false;
                const Term& lesser = clause.test.operands[clause.test.op == Op::Less ? 0 : 1];
                bool constant = true;
                each_variable(clause.test.operands[clause.test.op == Op::Less ? 1 : 0], [&](VariableId) { constant = false; });
                return constant && lesser.is_variable() && lesser.variable == value;
            });
        };
        return std::ranges::all_of(c.predicates, chooses) && std::ranges::all_of(c.rules, [&](RuleId id) {
                   const Rule& rule = program_.rules[id];
                   bool all = true;
                   each_atom(rule.body, [&](const Atom& a, bool negated) {
                       if (c.contains(a.predicate) && a.arguments[0].variable != rule.site) all = all && !negated && bounded(rule, a);
                   });
                   return all;
               });
    }
    // Whether every recursive link is one that the program makes (a parent, a child), not any neighbour: then the program is responsible
    // for its shape.
    bool led_by_routes(const check::Stratum& c) const {
        const auto led = [&](const Rule& rule, VariableId at) {
            return std::any_of(rule.body.begin(), rule.body.end(), [&](const Clause& clause) {
                if (clause.kind != Clause::Kind::Atom || clause.atom.arguments.size() < 2 || !clause.atom.arguments[1].is_variable())
                    return false;
                const Predicate& p = program_.predicates[clause.atom.predicate];
                const VariableId from = clause.atom.arguments[0].variable, to = clause.atom.arguments[1].variable;
                return p.world == WorldSource::None && p.kind == PredicateKind::Persistent &&
                       ((from == rule.site && to == at) || (from == at && to == rule.site));
            });
        };
        for (const RuleId id : c.rules) {
            const Rule& rule = program_.rules[id];
            bool all = true;
            each_atom(rule.body, [&](const Atom& a, bool) {
                const VariableId at = a.arguments[0].variable;
                all = all && (!c.contains(a.predicate) || at == rule.site || led(rule, at));
            });
            if (!all) return false;
        }
        return true;
    }
    // d(B, N + 1) :- d(A, N): a new fact for every N, for ever, unless an aggregate keeps only the best.
    bool warn_growth(const check::Stratum& c) {
        const std::vector<Growing> growing = growing_arguments(program_, c);
        for (const Growing& g : growing) {
            const Predicate& p = program_.predicates[g.predicate];
            // A bound would not help the value of a min or max: at the bound, values would appear and disappear for ever.
            report_
                .add(Kind::UnboundedArithmetic, g.span,
                     fmt::format("argument {} of `{}` may grow for ever: it is computed from `{}` again", g.argument + 1, p.name, p.name))
                .help = g.how == Growing::How::Longer    ? "bound its length with a condition, or let each element be in it only once"
                        : p.aggregate == Aggregate::None ? "keep only the least with `min`, or bound it with a condition"
                        : g.argument == p.aggregate_at   ? kGetWorse
                                                         : "bound it with a condition";
        }
        return !growing.empty();
    }

    // A rule by which a value passes from one predicate of the stratum to another.
    struct Way {
        PredicateId from, to;
        Span span;
        bool improves;
    };
    // m(B, D + 1) :- m(A, D), with max: at a bound the values would replace those they were made from.
    bool warn_improvement(const check::Stratum& c) {
        Aggregate best = Aggregate::None;
        for (const PredicateId p : c.predicates) {
            const Aggregate a = program_.predicates[p].aggregate;
            if (keeps_best(a)) best = best == Aggregate::None || best == a ? a : Aggregate::First;
        }
        if (!keeps_best(best)) return false;
        // With fronts, a value that improves up to a limit becomes quiescent there.
        const Improves how = fronts_of(program_, c) == Fronts::Needed ? Improves::Ever : Improves::ToALimit;
        std::vector<Way> ways;
        for (const RuleId id : c.rules)
            each_atom(program_.rules[id].body, [&](const Atom& a, bool negated) {
                if (!negated && c.contains(a.predicate)) add_ways(program_.rules[id], a, best, how, ways);
            });
        for (const Way& w : ways) {
            const std::vector<const Way*> back = w.improves ? way_back(ways, w) : std::vector<const Way*>{};
            if (!w.improves || (w.from != w.to && back.empty())) continue;
            const std::string& name = program_.predicates[w.to].name;
            auto& d = report_.add(Kind::ImprovesItself, w.span,
                                  fmt::format("`{}` may improve through itself: this may be better than what it is computed from", name));
            d.labels.push_back({w.span, fmt::format("`{}` is derived from `{}` here", name, program_.predicates[w.from].name)});
            for (const Way* b : back)
                d.labels.push_back(
                    {b->span, fmt::format("and `{}` of `{}` here", program_.predicates[b->to].name, program_.predicates[b->from].name)});
            d.help = kGetWorse;
            return true;
        }
        return false;
    }
    // p(A) :- m(A, 3) and m(A, 4) :- p(A), with max: the value does not pass on, but removes its own support.
    bool warn_replaced(const check::Stratum& c) {
        auto found = guarded_by_itself(program_, c);
        if (!found) found = replaced_by_itself(program_, c);
        if (!found) return false;
        const std::string& name = program_.predicates[found->predicate].name;
        auto& d = report_.add(Kind::ImprovesItself, found->made,
                              fmt::format("`{}` replaces the value that this is derived from, and then loses its support", name));
        d.labels.push_back({found->asked, "this is then no longer true"});
        for (const Replaced::Between& b : found->between)
            d.labels.push_back({b.span, fmt::format("`{}` is derived from `{}` here", program_.predicates[b.head].name,
                                                    program_.predicates[b.read].name)});
        const Aggregate kept = program_.predicates[found->predicate].aggregate;
        if (found->guard) {
            d.help = fmt::format("leave the comparison out: `{}` keeps the {} by itself", aggregate_name(kept),
                                 keeps_greatest(kept) ? "greatest" : "least");
            return true;
        }
        d.help = keeps_greatest(kept)
                     ? "test for at least this value, which better values pass too, or keep what has been reached in another predicate"
                     : "test for at most this value, which better values pass too, or keep what has been reached in another predicate";
        return true;
    }
    // q(A) :- p(A, _), where a better p may follow from q, and some rule does not hold for better values.
    bool warn_not_monotone(const check::Stratum& c) {
        const auto found = not_monotone(program_, c);
        if (!found) return false;
        const std::string& name = program_.predicates[found->asked].name;
        auto& d = report_.add(Kind::NotMonotone, found->ask,
                              fmt::format("this needs any value of `{}`, and a better one that follows from it may take it away", name));
        d.labels.push_back({found->breaks, "what holds of one value here need not hold of a better one"});
        d.help = "compute with values only in the `min` or `max` itself, and test only for bounds that better values pass too";
        return true;
    }
    // lit(A, ~X) :- neighbor(A, B), lit(B, X). Along links that the program makes, it ends if these form no cycle.
    void warn_inverted(const check::Stratum& c) {
        if (c.links && led_by_routes(c)) return;
        const auto found = inverts_itself(program_, c);
        if (!found) return;
        const std::string& name = program_.predicates[found->predicate].name;
        auto& d =
            report_.add(Kind::NotMonotone, found->made,
                        fmt::format("a better value of `{}` makes this worse, and itself in turn: both may come and go for ever", name));
        d.labels.push_back({found->read, fmt::format("`{}` is read here", name)});
        d.help = "decide one of the two without the other, or count the rounds in an argument before the aggregate and bound them";
    }
    void add_ways(const Rule& rule, const Atom& a, Aggregate best, Improves how, std::vector<Way>& ways) const {
        const Predicate &from = program_.predicates[a.predicate], &to = program_.predicates[rule.heads[0].atom.predicate];
        const auto carries = [](const Predicate& p, std::size_t i) { return p.aggregate == Aggregate::None || i == p.aggregate_at; };
        for (std::size_t i = 1; i < a.arguments.size(); ++i) {
            if (!carries(from, i) || !a.arguments[i].is_variable() || !a.arguments[i].type.numeric()) continue;
            const VariableId value = a.arguments[i].variable;
            for (std::size_t k = 1; k < to.arguments.size(); ++k) {
                const Term& made = rule.heads[0].atom.arguments[k];
                if (!carries(to, k) || !to.arguments[k].type.numeric()) continue;
                if (computed_from(rule, made, value))
                    ways.push_back({a.predicate, rule.heads[0].atom.predicate, made.span, improves(rule, made, value, best, how)});
            }
        }
    }
    // How a value passes from the end of this path to its beginning; the shortest way.
    static std::vector<const Way*> way_back(const std::vector<Way>& ways, const Way& through) {
        std::map<PredicateId, const Way*> came;
        std::vector<PredicateId> todo{through.to};
        for (std::size_t i = 0; i < todo.size(); ++i)
            for (const Way& w : ways)
                if (w.from == todo[i] && w.to != through.to && came.emplace(w.to, &w).second) todo.push_back(w.to);
        std::vector<const Way*> back;
        for (PredicateId at = through.from; at != through.to; at = back.back()->from) {
            const auto step = came.find(at);
            if (step == came.end()) return {};
            back.push_back(step->second);
        }
        std::reverse(back.begin(), back.end());
        return back;
    }

    const Program& program_;
    diagnostics::Reporter& report_;
    const Graph graph_;
};

}  // namespace

void warn_of_recursion(const Program& program, diagnostics::Reporter& report, Graph graph) { Recursion(program, report, graph).run(); }

}  // namespace meld::lint
