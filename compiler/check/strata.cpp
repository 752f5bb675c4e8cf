// Pass 5: components of mutually dependent predicates in evaluation order, and the recursion that is refused.
// Assumes homes; leaves Program::components sorted so that each reads only earlier ones and itself.
#include <algorithm>
#include <functional>
#include <map>

#include "compiler/check/check.h"
#include "compiler/check/fronts.h"
#include "compiler/check/replaced.h"
#include "compiler/check/rounds.h"
#include "compiler/check/values_read.h"

namespace meld::check {

using diagnostics::Kind;

namespace {

constexpr const char* kGetWorse =
    "let values stay or get worse from catom to catom, or count the turns in an argument before the aggregate";

struct Edge {
    PredicateId from, to;  // The head reads this.
    Span span;
    bool negated = false;
    bool aggregated = false;  // By an aggregate in a body.
    bool remote = false;
    bool waits = false;  // For all neighbours over this link.
};

class Strata {
  public:
    Strata(Program& program, diagnostics::Reporter& report) : program_(program), report_(report) {}

    void run() {
        edges_.resize(program_.predicates.count());
        for (const RuleId id : program_.rules.ids()) add_edges(id);
        for (const PredicateId p : program_.predicates.ids()) {
            const PredicateId link = program_.predicates[p].complete_link;
            if (link.valid()) edges_[p.index()].push_back({.from = p, .to = link, .span = program_.predicates[p].span, .waits = true});
        }
        find_components();
        for (Component& c : program_.components) classify(c);
    }

  private:
    void add_edges(RuleId id) {
        const Rule& rule = program_.rules[id];
        if (rule.linear || rule.refused) return;
        add_edges(rule, rule.body, {});
    }
    void add_edges(const Rule& rule, const std::vector<Clause>& body, Edge around) {
        for (const Clause& c : body) {
            if (c.kind == Clause::Kind::Atom || c.kind == Clause::Kind::Delta) {
                const Edge edge{rule.heads[0].atom.predicate,
                                c.atom.predicate,
                                c.atom.span,
                                around.negated || c.kind == Clause::Kind::Delta,
                                around.aggregated,
                                c.atom.arguments[0].variable != rule.home};
                edges_[rule.heads[0].atom.predicate.index()].push_back(edge);
            }
            Edge inside = around;
            inside.negated = true;
            inside.aggregated = around.aggregated || c.kind == Clause::Kind::Aggregate;
            add_edges(rule, c.inner, inside);
        }
    }

    // Tarjan's algorithm with its own stack; components come out with what they read first.
    void find_components() {
        const std::size_t n = program_.predicates.count();
        std::vector<std::size_t> order(n, 0), low(n, 0);
        std::vector<bool> open(n, false);
        std::vector<PredicateId> stack;
        std::size_t next = 1;
        struct Frame {
            PredicateId at;
            std::size_t edge;
        };
        for (const PredicateId root : program_.predicates.ids()) {
            if (order[root.index()] != 0) continue;
            std::vector<Frame> frames{{root, 0}};
            while (!frames.empty()) {
                Frame& f = frames.back();
                const std::size_t v = f.at.index();
                if (f.edge == 0 && order[v] == 0) {
                    order[v] = low[v] = next++;
                    stack.push_back(f.at);
                    open[v] = true;
                }
                if (f.edge < edges_[v].size()) {
                    const std::size_t w = edges_[v][f.edge++].to.index();
                    if (order[w] == 0)
                        frames.push_back({PredicateId(w), 0});
                    else if (open[w])
                        low[v] = std::min(low[v], order[w]);
                    continue;
                }
                if (low[v] == order[v]) close(v, stack, open);
                const PredicateId done = f.at;
                frames.pop_back();
                if (!frames.empty()) low[frames.back().at.index()] = std::min(low[frames.back().at.index()], low[done.index()]);
            }
        }
    }
    void close(std::size_t v, std::vector<PredicateId>& stack, std::vector<bool>& open) {
        Component c;
        for (;;) {
            const PredicateId p = stack.back();
            stack.pop_back();
            open[p.index()] = false;
            c.predicates.push_back(p);
            if (p.index() == v) break;
        }
        std::sort(c.predicates.begin(), c.predicates.end());
        program_.components.push_back(std::move(c));
    }

    void classify(Component& c) {
        const auto inside = [&](PredicateId p) { return std::find(c.predicates.begin(), c.predicates.end(), p) != c.predicates.end(); };
        for (const RuleId id : program_.rules.ids())
            if (!program_.rules[id].linear && inside(program_.rules[id].heads[0].atom.predicate)) c.rules.push_back(id);
        for (const PredicateId p : c.predicates) {
            const Predicate& head = program_.predicates[p];
            const bool all = head.needs_all();
            for (const Edge& e : edges_[p.index()]) {
                if (!inside(e.to)) continue;
                c.recursive = true;
                (e.remote ? c.links : c.local) = true;
                c.tree = c.tree || all;
                if (e.waits)
                    refuse(Kind::AggregateRecursion,
                           fmt::format("`{}` waits for all of `{}`, and `{}` needs `{}`", head.name, program_.predicates[e.to].name,
                                       program_.predicates[e.to].name, head.name),
                           p, e, c);
                else if (e.aggregated)
                    refuse(Kind::AggregateRecursion,
                           p == e.to ? fmt::format("`{}` aggregates itself: it would need all of its facts before the first", head.name)
                                     : fmt::format("`{}` aggregates `{}`, and `{}` needs `{}`", head.name, program_.predicates[e.to].name,
                                                   program_.predicates[e.to].name, head.name),
                           p, e, c);
                else if (e.negated)
                    refuse(Kind::NegativeRecursion,
                           p == e.to ? fmt::format("`{}` needs `not {}`: it would decide about itself", head.name, head.name)
                                     : fmt::format("`{}` needs `not {}`, and `{}` needs `{}`", head.name, program_.predicates[e.to].name,
                                                   program_.predicates[e.to].name, head.name),
                           p, e, c);
            }
        }
        if (c.tree) check_tree(c, inside);
        // Where a bounded number of rounds is counted, no value leads to itself.
        if (!c.recursive || c.tree || count_rounds(program_, c) == Rounds::Bounded) return;
        if (!warn_growth(c, inside) && !warn_improvement(c, inside) && !warn_replaced(c)) warn_not_monotone(c);
    }

    // A sum that feeds itself is fine only where every turn of the cycle crosses a link; so is a value that waits for neighbours.
    template <class Inside>
    void check_tree(const Component& c, const Inside& inside) {
        for (const PredicateId p : c.predicates) {
            if (program_.predicates[p].aggregate == Aggregate::None) continue;
            for (const Edge& e : edges_[p.index()])
                if (inside(e.to) && !e.remote && !e.waits && local_cycle(p, e.to, inside)) {
                    refuse(Kind::AggregateRecursion,
                           fmt::format("the {} `{}` feeds itself at one catom", aggregate_name(program_, program_.predicates[p]),
                                       program_.predicates[p].name),
                           p, e, c);
                    return;
                }
        }
        const auto folding =
            std::find_if(c.predicates.begin(), c.predicates.end(), [&](PredicateId q) { return program_.predicates[q].needs_all(); });
        const PredicateId p = *folding;
        if (led_by_routes(c, inside)) return;
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
            .help = "lead it along a spanning tree, as examples/meld/census.meld does";
    }
    // Whether every recursive link is one that the program keeps itself (a parent, a child), not any neighbour: then its
    // shape is the program's business.
    template <class Inside>
    bool led_by_routes(const Component& c, const Inside& inside) const {
        const auto led = [&](const Rule& rule, VariableId at) {
            return std::any_of(rule.body.begin(), rule.body.end(), [&](const Clause& clause) {
                if (clause.kind != Clause::Kind::Atom || clause.atom.arguments.size() < 2 || !clause.atom.arguments[1].is_variable())
                    return false;
                const Predicate& p = program_.predicates[clause.atom.predicate];
                const VariableId from = clause.atom.arguments[0].variable, to = clause.atom.arguments[1].variable;
                return p.world == WorldSource::None && p.kind == PredicateKind::Persistent &&
                       ((from == rule.home && to == at) || (from == at && to == rule.home));
            });
        };
        for (const RuleId id : c.rules) {
            const Rule& rule = program_.rules[id];
            bool all = true;
            each_atom(rule.body, [&](const Atom& a, bool) {
                const VariableId at = a.arguments[0].variable;
                all = all && (!inside(a.predicate) || at == rule.home || led(rule, at));
            });
            if (!all) return false;
        }
        return true;
    }
    template <class Inside>
    bool local_cycle(PredicateId goal, PredicateId from, const Inside& inside) {
        std::vector<PredicateId> todo{from}, seen;
        while (!todo.empty()) {
            const PredicateId at = todo.back();
            todo.pop_back();
            if (at == goal) return true;
            if (std::find(seen.begin(), seen.end(), at) != seen.end()) continue;
            seen.push_back(at);
            for (const Edge& e : edges_[at.index()])
                if (inside(e.to) && !e.remote && !e.waits) todo.push_back(e.to);
        }
        return false;
    }

    // Prints the cycle as a path of rules.
    void refuse(Kind kind, const std::string& what, PredicateId head, const Edge& through, const Component& c) {
        std::map<PredicateId, const Edge*> came;
        std::vector<PredicateId> todo{through.to};
        const auto inside = [&](PredicateId p) { return std::find(c.predicates.begin(), c.predicates.end(), p) != c.predicates.end(); };
        for (std::size_t i = 0; i < todo.size(); ++i)
            for (const Edge& e : edges_[todo[i].index()])
                if (inside(e.to) && !came.contains(e.to) && e.to != through.to) {
                    came[e.to] = &e;
                    todo.push_back(e.to);
                }
        auto& d = report_.add(kind, through.span, what);
        d.labels.push_back(
            {through.span, fmt::format("`{}` {} `{}` here", program_.predicates[head].name, through.waits ? "waits for" : "is derived from",
                                       program_.predicates[through.to].name)});
        std::vector<const Edge*> back;
        for (PredicateId at = head; at != through.to;) {
            const auto step = came.find(at);
            if (step == came.end()) break;
            back.push_back(step->second);
            at = step->second->from;
        }
        for (auto e = back.rbegin(); e != back.rend(); ++e) {
            const std::string& from = program_.predicates[(*e)->from].name;
            d.labels.push_back({(*e)->span, fmt::format("and `{}` from `{}` here", from, program_.predicates[(*e)->to].name)});
        }
        d.help = through.waits                     ? "decide the links without what waits for them"
                 : kind == Kind::NegativeRecursion ? "break the cycle: decide one of these facts without the other"
                                                   : "aggregate into another predicate, which the rules of the cycle do not read";
    }

    // d(B, N + 1) :- d(A, N): a new fact for every N, for ever, unless an aggregate keeps only the best.
    template <class Inside>
    bool warn_growth(const Component& c, const Inside& inside) {
        bool warned = false;
        for (const RuleId id : c.rules) {
            const Rule& rule = program_.rules[id];
            const Atom& head = rule.heads[0].atom;
            const Predicate& p = program_.predicates[head.predicate];
            for (std::size_t i = 1; i < head.arguments.size(); ++i) {
                const Term& t = head.arguments[i];
                if (t.op != Op::Add && t.op != Op::Multiply && t.op != Op::Subtract && t.op != Op::Power) continue;
                const bool worse = (keeps_least(p.aggregate) && t.op == Op::Add) || (keeps_greatest(p.aggregate) && t.op == Op::Subtract);
                if (p.aggregate == Aggregate::First || (worse && i == p.aggregate_at)) continue;
                if (p.aggregate != Aggregate::None && i > p.aggregate_at) continue;
                if (!comes_from(rule, t, inside)) continue;
                warned = true;
                // A bound would not help the value of a min or max: at it, values come and go for ever.
                report_
                    .add(Kind::UnboundedArithmetic, t.span,
                         fmt::format("argument {} of `{}` may grow for ever: it is computed from `{}` again", i + 1, p.name, p.name))
                    .help = p.aggregate == Aggregate::None ? "keep only the least with `min`, or bound it with a condition"
                            : i == p.aggregate_at          ? kGetWorse
                                                           : "bound it with a condition";
            }
        }
        return warned;
    }

    // A rule by which a value goes from one predicate of the component to another.
    struct Way {
        PredicateId from, to;
        Span span;
        bool improves;
    };
    // m(B, D + 1) :- m(A, D), with max: at a bound the values would replace those they were made from.
    template <class Inside>
    bool warn_improvement(const Component& c, const Inside& inside) {
        Aggregate best = Aggregate::None;
        for (const PredicateId p : c.predicates) {
            const Aggregate a = program_.predicates[p].aggregate;
            if (keeps_best(a)) best = best == Aggregate::None || best == a ? a : Aggregate::First;
        }
        if (!keeps_best(best)) return false;
        // With fronts, what improves up to a limit comes to rest there.
        const Improves how = fronts_of(program_, c) == Fronts::Needed ? Improves::Ever : Improves::ToALimit;
        std::vector<Way> ways;
        for (const RuleId id : c.rules)
            each_atom(program_.rules[id].body, [&](const Atom& a, bool negated) {
                if (!negated && inside(a.predicate)) add_ways(program_.rules[id], a, best, how, ways);
            });
        for (const Way& w : ways) {
            const std::vector<const Way*> back = w.improves ? way_back(ways, w) : std::vector<const Way*>{};
            if (!w.improves || (w.from != w.to && back.empty())) continue;
            const std::string& name = program_.predicates[w.to].name;
            auto& d = report_.add(Kind::ImprovesItself, w.span,
                                  fmt::format("`{}` may improve through itself: this may be better than what it is computed from", name));
            d.labels.push_back({w.span, fmt::format("`{}` is made of `{}` here", name, program_.predicates[w.from].name)});
            for (const Way* b : back)
                d.labels.push_back(
                    {b->span, fmt::format("and `{}` of `{}` here", program_.predicates[b->to].name, program_.predicates[b->from].name)});
            d.help = kGetWorse;
            return true;
        }
        return false;
    }
    // p(A) :- m(A, 3) and m(A, 4) :- p(A), with max: no way that a value goes, but one that it is gone by.
    bool warn_replaced(const Component& c) {
        const auto found = replaced_by_itself(program_, c);
        if (!found) return false;
        const std::string& name = program_.predicates[found->predicate].name;
        auto& d = report_.add(Kind::ImprovesItself, found->made,
                              fmt::format("`{}` replaces the value that this follows from, and loses it again", name));
        d.labels.push_back({found->asked, "this is no longer so then"});
        for (const Replaced::Between& b : found->between)
            d.labels.push_back(
                {b.span, fmt::format("`{}` is made of `{}` here", program_.predicates[b.head].name, program_.predicates[b.read].name)});
        d.help = keeps_greatest(program_.predicates[found->predicate].aggregate)
                     ? "ask for at least so much, which better values pass too, or keep what has been reached in another predicate"
                     : "ask for at most so much, which better values pass too, or keep what has been reached in another predicate";
        return true;
    }
    // q(A) :- p(A, _), where a better p may follow from q, and some rule does not hold for better values.
    void warn_not_monotone(const Component& c) {
        const auto found = not_monotone(program_, c);
        if (!found) return;
        const std::string& name = program_.predicates[found->asked].name;
        auto& d = report_.add(Kind::NotMonotone, found->ask,
                              fmt::format("this needs any value of `{}`, and a better one that follows from it may take it away", name));
        d.labels.push_back({found->breaks, "what holds of one value here need not hold of a better one"});
        d.help = "compute with values only in the `min` or `max` itself, and ask for at most or at least so much";
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
    // How a value goes from where this way leads to where it begins; the shortest.
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

    template <class Inside>
    static bool comes_from(const Rule& rule, const Term& t, const Inside& inside) {
        bool found = false, bounded = false;
        each_variable(t, [&](VariableId v) {
            each_atom(rule.body, [&](const Atom& a, bool negated) {
                for (const Term& argument : a.arguments)
                    found = found || (!negated && inside(a.predicate) && argument.is_variable() && argument.variable == v);
            });
            for (const Clause& clause : rule.body)
                if (clause.kind == Clause::Kind::Test && (clause.test.op == Op::Less || clause.test.op == Op::LessEqual ||
                                                          clause.test.op == Op::Greater || clause.test.op == Op::GreaterEqual))
                    each_variable(clause.test, [&](VariableId w) { bounded = bounded || w == v; });
        });
        return found && !bounded;
    }

    Program& program_;
    diagnostics::Reporter& report_;
    std::vector<std::vector<Edge>> edges_;
};

}  // namespace

void stratify(Program& program, diagnostics::Reporter& report) { Strata(program, report).run(); }

}  // namespace meld::check
