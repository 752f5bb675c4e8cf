// Pass `relay`. A linear rule may make a fact at a catom that is more than one link away; it goes from hand to hand:
//     a(A, X), neighbor(A, B), neighbor(B, C) -o p(C, X).
// becomes
//     a(A, X), neighbor(A, B), neighbor(B, C) -o p@far1(B, C, X).      p@far1(B, C, X) -o p(C, X).
// Where the next link is gone by then, the fact is dropped and counted, like any other on its way.
#include <algorithm>
#include <map>
#include <set>

#include "compiler/desugar/desugar.h"
#include "compiler/desugar/made.h"

namespace meld::desugar {

using namespace check;

namespace {

using Graph = std::map<VariableId, std::set<VariableId>>;

class Relays {
  public:
    explicit Relays(Program& program) : program_(program) {}

    void run() {
        for (std::size_t i = 0, end = program_.rules.count(); i < end; ++i) {
            const RuleId id(i);
            if (!program_.rules[id].linear || program_.rules[id].initial_fact) continue;
            Rule rule = program_.rules[id];
            Graph graph;
            links(rule.body, graph);
            heads(rule, rule.heads, graph);
            program_.rules[id] = std::move(rule);
        }
    }

  private:
    void links(const std::vector<Clause>& body, Graph& graph) const {
        for (const Clause& c : body) {
            if (c.kind != Clause::Kind::Atom || !program_.predicates[c.atom.predicate].route) continue;
            if (c.atom.arguments.size() < 2 || !c.atom.arguments[1].is_variable()) continue;
            graph[c.atom.arguments[0].variable].insert(c.atom.arguments[1].variable);
            graph[c.atom.arguments[1].variable].insert(c.atom.arguments[0].variable);
        }
    }

    void heads(const Rule& rule, std::vector<Head>& all, const Graph& around) {
        for (Head& h : all) {
            if (h.kind == Head::Kind::Fact) {
                send(rule, h.atom, around);
                continue;
            }
            Graph graph = around;
            links(h.body, graph);
            heads(rule, h.heads, graph);
            heads(rule, h.others, h.kind == Head::Kind::Aggregate ? around : graph);
        }
    }

    // The catoms after the execution site up to the goal, along a shortest path; of equals the first in the rule.
    static std::vector<VariableId> way(const Graph& graph, VariableId site, VariableId goal) {
        std::map<VariableId, VariableId> came;
        std::vector<VariableId> todo{site};
        for (std::size_t i = 0; i < todo.size(); ++i) {
            const auto next = graph.find(todo[i]);
            if (next == graph.end()) continue;
            for (const VariableId v : next->second)
                if (v != site && came.emplace(v, todo[i]).second) todo.push_back(v);
        }
        MELD_CHECK(came.contains(goal), "no link leads to the catom of a head");
        std::vector<VariableId> out;
        for (VariableId at = goal; at != site; at = came.at(at)) out.push_back(at);
        std::reverse(out.begin(), out.end());
        return out;
    }

    void send(const Rule& rule, Atom& atom, const Graph& graph) {
        const VariableId goal = atom.arguments[0].variable;
        if (goal == rule.site) return;
        const std::vector<VariableId> path = way(graph, rule.site, goal);
        if (path.size() < 2) return;
        atom.predicate = relay(atom.predicate, path.size() - 1);
        std::vector<Term> arguments;
        for (const VariableId v : path) arguments.push_back(variable_of(rule, v));
        arguments.insert(arguments.end(), atom.arguments.begin() + 1, atom.arguments.end());
        atom.arguments = std::move(arguments);
    }

    // The auxiliary for facts of p with this many links still to go, made with its rule on first use. Its arguments are the present catom,
    // the next catoms, and the arguments of p.
    PredicateId relay(PredicateId p, std::size_t left) {
        const auto found = relays_.find({p, left});
        if (found != relays_.end()) return found->second;
        MELD_EXPECT(left > 0 && program_.predicates[p].kind != PredicateKind::Sensed, "{} cannot be handed on",
                    program_.predicates[p].name);
        const PredicateId next = left == 1 ? p : relay(p, left - 1);
        Predicate made;
        made.name = fmt::format("{}@far{}", program_.predicates[p].name, left);
        made.span = program_.predicates[p].span;
        made.kind = PredicateKind::Linear;
        made.auxiliary = true;
        const Predicate& sent = program_.predicates[p];
        made.carries = sent.carries.valid() ? sent.carries : p;
        made.passes = left;
        made.behind = sent.behind;
        made.arguments.assign(left, {Type::Node, ""});
        made.arguments.insert(made.arguments.end(), program_.predicates[p].arguments.begin(), program_.predicates[p].arguments.end());
        const PredicateId id = program_.predicates.add(made);
        MadeRule hand(program_, id, made.name);
        hand.rule.linear = hand.rule.arrives = true;
        hand.head(program_, next, 1);
        hand.add_to(program_);
        return relays_[{p, left}] = id;
    }

    Program& program_;
    std::map<std::pair<PredicateId, std::size_t>, PredicateId> relays_;
};

}  // namespace

void relay_heads(Program& program) { Relays(program).run(); }

}  // namespace meld::desugar
