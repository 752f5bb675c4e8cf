// Pass 5: strata, sets of mutually dependent predicates in the order of evaluation, and the recursion that is an error. Recursion
// that may not end is reported by compiler/lint. Assumes execution sites; leaves Program::strata sorted so that each reads only
// earlier ones and itself.
#include <algorithm>
#include <functional>
#include <map>
#include <string_view>

#include "compiler/check/analysis/rounds.h"
#include "compiler/check/check.h"
#include "compiler/check/program/forall.h"
#include "runtime/base/assert.h"

namespace meld::check {

using diagnostics::Kind;

namespace {

struct Edge {
    PredicateId from, to;  // The head reads this.
    Span span;
    bool negated = false;
    const char* asks = "not";  // The word of the negation, as in messages.
    bool aggregated = false;   // By an aggregate in a body.
    bool remote = false;
    bool waits = false;  // For all neighbours over this link.

    // Asks what has changed in a tick, which no round says.
    bool changes() const { return asks == std::string_view("delta"); }
};

class Strata {
  public:
    Strata(Program& program, diagnostics::Reporter& report) : program_(program), report_(report) {}

    void run() {
        edges_.resize(program_.predicates.count());
        rules_of_.resize(program_.predicates.count());
        for (const RuleId id : program_.rules.ids()) {
            add_edges(id);
            const Rule& rule = program_.rules[id];
            if (!rule.linear && !rule.heads.empty()) rules_of_[rule.heads[0].atom.predicate.index()].push_back(id);
        }
        for (const PredicateId p : program_.predicates.ids()) {
            const PredicateId link = program_.predicates[p].complete_link;
            if (link.valid()) edges_[p.index()].push_back({.from = p, .to = link, .span = program_.predicates[p].span, .waits = true});
        }
        find_strongly_connected();
        MELD_ASSERT(program_.strata.size() <= program_.predicates.count(), "{} strata of {} predicates", program_.strata.size(),
                    program_.predicates.count());
        for (Stratum& c : program_.strata) classify(c);
    }

  private:
    void add_edges(RuleId id) {
        const Rule& rule = program_.rules[id];
        if (rule.linear || rule.refused) return;
        MELD_EXPECT(rule.heads.size() == 1 && rule.heads[0].kind == Head::Kind::Fact, "view {} has {} heads", rule.name, rule.heads.size());
        add_edges(rule, rule.body, {});
    }
    void add_edges(const Rule& rule, const std::vector<Clause>& body, Edge around) {
        for (const Clause& c : body) {
            if (c.kind == Clause::Kind::Atom || c.kind == Clause::Kind::Delta) {
                const bool delta = c.kind == Clause::Kind::Delta;
                const Edge edge{.from = rule.heads[0].atom.predicate,
                                .to = c.atom.predicate,
                                .span = c.atom.span,
                                .negated = around.negated || delta,
                                .asks = delta ? "delta" : around.asks,
                                .aggregated = around.aggregated,
                                .remote = c.atom.arguments[0].variable != rule.site};
                edges_[rule.heads[0].atom.predicate.index()].push_back(edge);
            }
            Edge inside = around;
            inside.negated = true;
            if (is_forall(c)) inside.asks = "forall";
            inside.aggregated = around.aggregated || c.kind == Clause::Kind::Aggregate;
            add_edges(rule, c.inner, inside);
        }
    }

    // Tarjan's algorithm with its own stack; components come out with what they read first.
    void find_strongly_connected() {
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
        Stratum c;
        for (;;) {
            MELD_ASSERT(!stack.empty(), "the stratum of {} is not on the stack", program_.predicates[PredicateId(v)].name);
            const PredicateId p = stack.back();
            stack.pop_back();
            open[p.index()] = false;
            c.predicates.push_back(p);
            if (p.index() == v) break;
        }
        std::sort(c.predicates.begin(), c.predicates.end());
        program_.strata.push_back(std::move(c));
    }

    void classify(Stratum& c) {
        for (const PredicateId p : c.predicates) c.rules.insert(c.rules.end(), rules_of_[p.index()].begin(), rules_of_[p.index()].end());
        std::sort(c.rules.begin(), c.rules.end());
        for (const PredicateId p : c.predicates)
            for (const Edge& e : edges_[p.index()]) {
                if (!c.contains(e.to)) continue;
                c.recursive = true;
                (e.remote ? c.links : c.local) = true;
                c.tree = c.tree || program_.predicates[p].needs_all();
            }
        count(c);
        for (const PredicateId p : c.predicates) {
            const Predicate& head = program_.predicates[p];
            for (const Edge& e : edges_[p.index()]) {
                if (!c.contains(e.to) || (c.rounds && !e.waits && !e.changes())) continue;
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
                           p == e.to ? fmt::format("`{}` needs {}: it would decide about itself", head.name, question(e))
                                     : fmt::format("`{}` needs {}, and `{}` needs `{}`", head.name, question(e),
                                                   program_.predicates[e.to].name, head.name),
                           p, e, c);
            }
        }
        if (c.tree && !c.rounds) check_tree(c);
    }

    // Where facts negate or aggregate each other: whether rounds separate them. What the planner adds to such a stratum follows its rounds.
    void count(Stratum& c) {
        bool needed = false, known = false;
        for (const PredicateId p : c.predicates) {
            known = known || program_.predicates[p].in_rounds;
            for (const Edge& e : edges_[p.index()])
                needed = needed || (c.contains(e.to) && (e.negated || (program_.predicates[p].needs_all() && feeds_itself(p, e, c))));
        }
        if (!needed && !known) return;
        counted_ = known ? Rounds::Bounded : count_rounds(program_, c);
        if (counted_ != Rounds::Bounded) return;
        c.rounds = c.tree = true;
        for (const PredicateId p : c.predicates) program_.predicates[p].in_rounds = true;
    }

    // `not p`, or p inside another word that asks for what is absent.
    std::string question(const Edge& e) const {
        const std::string& name = program_.predicates[e.to].name;
        const std::string_view asks = e.asks;
        if (asks == "not") return fmt::format("`not {}`", name);
        return asks == "forall" ? fmt::format("a `forall` over `{}`", name) : fmt::format("the `{}` of `{}`", asks, name);
    }

    // A sum that depends on itself is allowed only if every cycle crosses a link; so is a value that waits for neighbours.
    void check_tree(Stratum& c) {
        for (const PredicateId p : c.predicates) {
            if (program_.predicates[p].aggregate == Aggregate::None) continue;
            for (const Edge& e : edges_[p.index()])
                if (feeds_itself(p, e, c)) {
                    refuse(Kind::AggregateRecursion,
                           fmt::format("the {} `{}` feeds itself at one catom", aggregate_name(program_, program_.predicates[p]),
                                       program_.predicates[p].name),
                           p, e, c);
                    c.feeds_itself = true;
                    return;
                }
        }
    }
    bool feeds_itself(PredicateId p, const Edge& e, const Stratum& c) {
        return c.contains(e.to) && !e.remote && !e.waits && local_cycle(p, e.to, c);
    }
    bool local_cycle(PredicateId goal, PredicateId from, const Stratum& c) {
        MELD_EXPECT(c.contains(goal) && c.contains(from), "{} and {} are of two strata", program_.predicates[goal].name,
                    program_.predicates[from].name);
        std::vector<PredicateId> todo{from}, seen;
        while (!todo.empty()) {
            const PredicateId at = todo.back();
            todo.pop_back();
            if (at == goal) return true;
            if (std::find(seen.begin(), seen.end(), at) != seen.end()) continue;
            seen.push_back(at);
            for (const Edge& e : edges_[at.index()])
                if (c.contains(e.to) && !e.remote && !e.waits) todo.push_back(e.to);
        }
        return false;
    }

    // Prints the cycle as a path of rules.
    void refuse(Kind kind, const std::string& what, PredicateId head, const Edge& through, const Stratum& c) {
        MELD_EXPECT(through.from == head && c.contains(head) && c.contains(through.to), "no cycle through {}",
                    program_.predicates[head].name);
        std::map<PredicateId, const Edge*> came;
        std::vector<PredicateId> todo{through.to};
        for (std::size_t i = 0; i < todo.size(); ++i)
            for (const Edge& e : edges_[todo[i].index()])
                if (c.contains(e.to) && !came.contains(e.to) && e.to != through.to) {
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
        const bool may_count = !through.waits && !through.changes();
        d.help = through.waits ? "derive the links without the facts that wait for them"
                 : may_count && counted_ == Rounds::Endless
                     ? "bound the number of the round, as in R < 20: then each round reads only earlier ones"
                 : kind == Kind::NegativeRecursion ? "break the cycle: decide one of these facts without the other"
                                                   : fmt::format(
                                                         "derive another predicate here, such as `{}-of-all`, and read that "
                                                         "outside of the cycle",
                                                         program_.predicates[head].name);
    }

    Program& program_;
    diagnostics::Reporter& report_;
    std::vector<std::vector<Edge>> edges_;       // By the predicate of the head.
    std::vector<std::vector<RuleId>> rules_of_;  // The views that derive a predicate.
    Rounds counted_ = Rounds::None;              // Of the stratum at hand.
};

}  // namespace

void stratify(Program& program, diagnostics::Reporter& report) { Strata(program, report).run(); }

}  // namespace meld::check
