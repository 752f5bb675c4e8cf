// Pass `relay`. A linear rule may make a fact at a catom that is more than one link away; it goes from hand to hand:
//     a(A, X), neighbor(A, B), neighbor(B, C) -o p(C, X).
// becomes
//     a(A, X), neighbor(A, B), neighbor(B, C) -o p@far1(B, C, X).      p@far1(B, C, X) -o p(C, X).
// Where the next link is gone by then, the fact is dropped and counted, like any other on its way.
//
// In a graph the target may also be known only by its value. Then the fact finds its way hop by hop:
//     a(A, B, X) -o p(B, X).
// becomes
//     a(A, B, X) -o p@to(A, B, X).            p@to(A, B, X), B = A -o p(A, X).
//                                             p@to(A, B, X), B <> A, C = next_hop(B) -o p@to(C, B, X).
// and, if the program declares undelivered-p, in between
//                                             p@to(A, B, X), B <> A, next_hop(B) = A -o undelivered-p(A, B, X).
//
// Facts at a node that the rule makes go to it directly, and the node begins with them:
//     a(A, X) -o exists B. (p(B, X)).
// becomes
//     a(A, X) -o B = new node, p@new(B, X).   p@new(B, X) -o p(B, X).
// An action of another catom is requested there:
//     a(A), neighbor(A, B) -o setColor2(B, 3).
// becomes
//     a(A), neighbor(A, B) -o setColor2@there(B, 3).     setColor2@there(B, X) -o setColor2(B, X).
//
// New nodes have no links. So in a program that makes nodes, facts along its own routes, edge(A, B), find their way, too.
#include <algorithm>
#include <map>

#include "compiler/desugar/desugar.h"
#include "compiler/desugar/made.h"

namespace meld::desugar {

using namespace check;

namespace {

using Graph = std::map<VariableId, Variables>;

class Relays {
  public:
    explicit Relays(Program& program) : program_(program) {}

    void run() {
        for (const PredicateId id : program_.predicates.ids())
            if (const Predicate& p = program_.predicates[id]; p.returns.valid()) back_.emplace(p.returns, id);
        if (program_.worlds == Worlds::Graphs)
            for (const Rule& rule : program_.rules) makes_nodes_ = makes_nodes_ || (rule.linear && makes_node(rule.heads, {}));
        for (std::size_t i = 0, end = program_.rules.count(); i < end; ++i) {
            const RuleId id(i);
            if (!program_.rules[id].linear || program_.rules[id].initial_fact) continue;
            Rule rule = program_.rules[id];
            Graph graph;
            links(rule.body, graph);
            heads(rule, rule.heads, graph);
            program_.rules[id] = std::move(rule);
            made_.clear();
        }
    }

  private:
    // Whether some fact is at a node that the rule makes.
    static bool makes_node(const std::vector<Head>& heads, Variables fresh) {
        return std::ranges::any_of(heads, [&](const Head& h) {
            if (h.kind == Head::Kind::Fact) return fresh.contains(h.atom.arguments[0].variable);
            if (h.kind == Head::Kind::Set && h.term.op == Op::Fresh) fresh.insert(h.variable);
            return makes_node(h.heads, fresh) || makes_node(h.others, fresh);
        });
    }

    // New nodes have no links, so where there are some, only `neighbor` says that a link leads to a catom.
    bool leads(const Predicate& p) const { return p.route && (p.prelude || !makes_nodes_); }

    void links(const std::vector<Clause>& body, Graph& graph) const {
        for (const Clause& c : body) {
            if (c.kind != Clause::Kind::Atom || !leads(program_.predicates[c.atom.predicate])) continue;
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
            const bool fresh = h.kind == Head::Kind::Set && h.term.op == Op::Fresh;
            if (fresh) made_.emplace(h.variable, false);
            heads(rule, h.heads, graph);
            heads(rule, h.others, h.kind == Head::Kind::Aggregate ? around : graph);
            if (fresh && made_.at(h.variable)) h.term.op = Op::NewNode;
        }
    }

    // The catoms after the execution site up to the goal, along a shortest path; of equals the first in the rule. Empty: there is none.
    static std::vector<VariableId> way(const Graph& graph, VariableId site, VariableId goal) {
        std::map<VariableId, VariableId> came;
        std::vector<VariableId> todo{site};
        for (std::size_t i = 0; i < todo.size(); ++i) {
            const auto next = graph.find(todo[i]);
            if (next == graph.end()) continue;
            for (const VariableId v : next->second)
                if (v != site && came.emplace(v, todo[i]).second) todo.push_back(v);
        }
        if (!came.contains(goal)) return {};
        std::vector<VariableId> out;
        for (VariableId at = goal; at != site; at = came.at(at)) out.push_back(at);
        std::reverse(out.begin(), out.end());
        return out;
    }

    void send(const Rule& rule, Atom& atom, const Graph& graph) {
        const VariableId goal = atom.arguments[0].variable;
        if (goal == rule.site) return;
        if (program_.predicates[atom.predicate].kind == PredicateKind::Action) atom.predicate = request(atom.predicate);
        if (const auto made = made_.find(goal); made != made_.end()) {
            MELD_CHECK(program_.worlds == Worlds::Graphs, "a fact at a new value");
            made->second = true;
            atom.predicate = beginning(atom.predicate);
            return;
        }
        const std::vector<VariableId> path = way(graph, rule.site, goal);
        if (path.empty()) {
            MELD_CHECK(program_.worlds == Worlds::Graphs, "no link leads to the catom of a head");
            atom.predicate = finding(atom.predicate);
            atom.arguments.insert(atom.arguments.begin(), variable_of(rule, rule.site));
            return;
        }
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
        const PredicateId id = carrier(p, fmt::format("{}@far{}", program_.predicates[p].name, left), left);
        MadeRule hand(program_, id, program_.predicates[id].name);
        hand.rule.linear = hand.rule.arrives = true;
        hand.head(program_, next, 1);
        hand.add_to(program_);
        return relays_[{p, left}] = id;
    }

    // The auxiliary for requests of an action to another catom, made with its rule on first use. Its arguments are those of the action.
    PredicateId request(PredicateId action) {
        const auto found = requests_.find(action);
        if (found != requests_.end()) return found->second;
        const PredicateId id = carrier(action, program_.predicates[action].name + "@there", 0);
        MadeRule rule(program_, id, program_.predicates[id].name);
        rule.rule.linear = rule.rule.arrives = true;
        rule.head(program_, action, 0);
        rule.add_to(program_);
        return requests_[action] = id;
    }

    // The auxiliary for facts of p with which a node begins, made with its rule on first use. Its arguments are those of p.
    PredicateId beginning(PredicateId p) {
        const auto found = beginning_.find(p);
        if (found != beginning_.end()) return found->second;
        const PredicateId id = carrier(p, program_.predicates[p].name + "@new", 0);
        program_.predicates[id].begins = true;
        MadeRule rule(program_, id, program_.predicates[id].name);
        rule.rule.linear = rule.rule.arrives = true;
        rule.head(program_, p, 0);
        rule.add_to(program_);
        return beginning_[p] = id;
    }

    // The auxiliary for facts of p under way to a catom that no link of the rule leads to, made with its rules on first use. Its arguments
    // are the present catom and those of p.
    PredicateId finding(PredicateId p) {
        const auto found = finding_.find(p);
        if (found != finding_.end()) return found->second;
        const std::string name = program_.predicates[p].name + "@to";
        const PredicateId id = carrier(p, name, 1);
        program_.predicates[id].finds_its_way = true;
        const auto compare = [](Op op, const Term& a, const Term& b) {
            Clause c{.kind = Clause::Kind::Test};
            c.test = made_term(op, Type::Bool, {a, b});
            return c;
        };
        const auto made = [&](const char* what, Op here, const auto& rest) {
            MadeRule rule(program_, id, name + what);
            rule.rule.linear = rule.rule.arrives = true;
            const std::vector<Term>& all = rule.body.atom.arguments;
            rule.rule.body.push_back(compare(here, all[1], all[0]));
            rest(rule, all);
            rule.add_to(program_);
        };
        made(".here", Op::Equal, [&](MadeRule& rule, const std::vector<Term>& all) {
            rule.head(program_, p, 1);
            rule.rule.heads[0].atom.arguments[0] = all[0];
        });
        const Predicate& carried = program_.predicates[id];
        if (const auto back = back_.find(carried.carries); back != back_.end())
            made(".back", Op::NotEqual, [&](MadeRule& rule, const std::vector<Term>& all) {
                rule.rule.body.push_back(compare(Op::Equal, made_term(Op::NextHop, Type::Node, {all[1]}), all[0]));
                rule.head(program_, back->second, 0);
                // What the program asks for, as if it said so itself.
                rule.rule.derives = {back->second};
            });
        made(".on", Op::NotEqual, [&](MadeRule& rule, const std::vector<Term>& all) {
            const Term next = variable_of(rule.rule, rule.rule.variables.add({"Next", rule.rule.span, Type::Node}));
            rule.rule.body.push_back(compare(Op::Equal, next, made_term(Op::NextHop, Type::Node, {all[1]})));
            rule.head(program_, id, 0);
            rule.rule.heads[0].atom.arguments[0] = next;
        });
        return finding_[p] = id;
    }

    // A linear auxiliary with the arguments of p, and before them this many catoms.
    PredicateId carrier(PredicateId p, std::string name, std::size_t catoms) {
        const Predicate& sent = program_.predicates[p];
        Predicate made;
        made.name = std::move(name);
        made.span = sent.span;
        made.kind = PredicateKind::Linear;
        made.auxiliary = true;
        made.carries = sent.carries.valid() ? sent.carries : p;
        made.passes = catoms;
        made.behind = sent.behind;
        made.arguments.assign(catoms, {Type::Node, ""});
        made.arguments.insert(made.arguments.end(), sent.arguments.begin(), sent.arguments.end());
        return program_.predicates.add(made);
    }

    Program& program_;
    std::map<PredicateId, PredicateId> back_;  // `undelivered-p` by p.
    std::map<PredicateId, PredicateId> finding_, beginning_, requests_;
    bool makes_nodes_ = false;
    std::map<VariableId, bool> made_;  // By `exists` in the present rule; whether facts are at them.
    std::map<std::pair<PredicateId, std::size_t>, PredicateId> relays_;
};

}  // namespace

void relay_heads(Program& program) { Relays(program).run(); }

}  // namespace meld::desugar
