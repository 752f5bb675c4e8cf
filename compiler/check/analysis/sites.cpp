// Pass 3: locality. Gives each rule its execution site and rejects bodies whose catoms no link connects to it.
// A link is an atom of a route predicate (neighbor, or one declared `route`) whose second argument is a variable; it is
// followed in both directions, because neighbours hear each other.
#include <algorithm>
#include <map>
#include <set>
#include <string_view>

#include "compiler/check/analysis/own_graph.h"
#include "compiler/check/analysis/split_linear.h"
#include "compiler/check/check.h"
#include "compiler/check/program/forall.h"
#include "runtime/base/assert.h"

namespace meld::check {

using diagnostics::Kind;

namespace {

constexpr const char* kFindsItself =
    ". Only in a world with `lattice = \"graph\"` would it find its way by itself; --graph compiles for such a world";

class Sites {
  public:
    Sites(const Program& program, Rule& rule, diagnostics::Reporter& report) : program_(program), rule_(rule), report_(report) {}

    void run() {
        if (!rule_.linear || rule_.initial_fact)
            view();
        else
            linear();
    }
    // Whether some head is at a catom that no link leads to.
    bool finds_way() const { return finds_way_; }

  private:
    using Graph = std::map<VariableId, Variables>;

    const std::string& name(VariableId v) const { return rule_.variables[v].name; }
    // As the program writes it: a variable's name, or the catom that a variable without one stands for, @3; empty: it is left open.
    std::string written(VariableId v) const {
        if (!name(v).starts_with("_")) return name(v);
        for (const std::vector<Clause>* body : {&rule_.body, &rule_.stands_for})
            for (const Clause& c : *body) {
                if (c.kind != Clause::Kind::Test || c.test.op != Op::Equal) continue;
                for (const std::size_t side : {0u, 1u})
                    if (c.test.operands[side].is_variable() && c.test.operands[side].variable == v &&
                        !c.test.operands[1 - side].is_variable())
                        return print(program_, rule_, c.test.operands[1 - side]);
            }
        return "";
    }
    std::string shown(VariableId v) const {
        const std::string text = written(v);
        return text.empty() ? "this catom" : "`" + text + "`";
    }

    // Only positive facts lead to catoms, not those that are negated or aggregated.
    void links(const std::vector<Clause>& body, Graph& graph) const {
        for (const Clause& c : body) {
            if (c.kind != Clause::Kind::Atom) continue;
            const Atom& a = c.atom;
            MELD_EXPECT(a.arguments[0].is_variable(), "{} is read at no variable", program_.predicates[a.predicate].name);
            if (!program_.predicates[a.predicate].route || a.arguments.size() < 2 || !a.arguments[1].is_variable()) continue;
            graph[a.arguments[0].variable].insert(a.arguments[1].variable);
            graph[a.arguments[1].variable].insert(a.arguments[0].variable);
        }
    }
    static Variables reached(const Graph& graph, VariableId from) {
        Variables seen{from};
        std::vector<VariableId> todo{from};
        while (!todo.empty()) {
            const VariableId at = todo.back();
            todo.pop_back();
            if (const auto next = graph.find(at); next != graph.end())
                for (const VariableId v : next->second)
                    if (seen.insert(v)) todo.push_back(v);
        }
        return seen;
    }

    // Every atom must be at a reached catom; `graph` holds the links of the bodies around, and `around` is the clause that has this body.
    void check_body(const std::vector<Clause>& body, Graph graph, const Clause* around = nullptr) {
        MELD_EXPECT(rule_.site.valid(), "rule {} runs nowhere yet", rule_.name);
        links(body, graph);
        const Variables seen = reached(graph, rule_.site);
        for (const Clause& c : body) {
            check_body(c.inner, graph, &c);
            if (c.kind == Clause::Kind::Delta) check_delta(c);
            if (c.kind != Clause::Kind::Atom) continue;
            const VariableId at = c.atom.arguments[0].variable;
            if (seen.contains(at) || !refused_.insert(at)) continue;
            no_route(c, at, body, around);
            // Everything connected with it misses the same link.
            for (const VariableId v : reached(graph, at)) refused_.insert(v);
        }
    }

    // Only the catom itself knows what held before the tick.
    void check_delta(const Clause& c) {
        MELD_EXPECT(c.kind == Clause::Kind::Delta, "rule {}: not a delta", rule_.name);
        const VariableId at = c.atom.arguments[0].variable;
        if (at == rule_.site || !refused_.insert(at)) return;
        auto& d = report_.add(Kind::DeltaElsewhere, c.atom.arguments[0].span,
                              fmt::format("the rule runs at {}, and this is a change at {}", shown(rule_.site), shown(at)));
        d.labels.push_back({rule_.variables[rule_.site].span, fmt::format("the rule runs at {}", shown(rule_.site))});
        d.help = "record the change there by a separate rule, and read the record";
    }

    void no_route(const Clause& clause, VariableId at, const std::vector<Clause>& body, const Clause* around) {
        const Atom& atom = clause.atom;
        auto& d = report_.add(Kind::NoRoute, atom.arguments[0].span,
                              fmt::format("no route from {} to {}: nothing in the body connects them", shown(rule_.site), shown(at)));
        d.labels.push_back({rule_.variables[rule_.site].span, fmt::format("the rule runs at {}", shown(rule_.site))});
        if (blame_pointer(body, at, d)) return;
        const std::string from = written(rule_.site), to = written(at);
        if (from.empty() || to.empty()) {
            d.help = "join the catoms by `neighbor`";
            return;
        }
        const std::string added = link(from, to);
        d.help = fmt::format("add `{}`, or another route between them", added);
        suggest_link(added, clause, around, d);
    }

    // The link before a fact of a body. A negation of one fact gets brackets; what a `forall` asks first has no place for a second.
    static void suggest_link(const std::string& added, const Clause& clause, const Clause* around, diagnostics::Diagnostic& d) {
        const Span fact = clause.atom.span;
        const bool written = fact.end > fact.begin && clause.span.begin == fact.begin && clause.span.end == fact.end;
        if (!written || (around != nullptr && is_forall(*around))) return;
        diagnostics::Fix fix = diagnostics::insert(fact, added + ", ");
        fix.title = fmt::format("Add `{}`", added);
        if (around != nullptr && around->kind == Clause::Kind::Not && around->span.end == fact.end) {
            fix.edits.front().text.insert(0, "(");
            fix.edits.push_back({{fact.file, fact.end, fact.end}, ")"});
        }
        d.fixes = {std::move(fix)};
    }

    // A predicate that names the catom, as a link would, but is not declared as a route.
    bool blame_pointer(const std::vector<Clause>& body, VariableId at, diagnostics::Diagnostic& d) const {
        for (const Clause& c : body) {
            if (c.kind != Clause::Kind::Atom) continue;
            const Predicate& p = program_.predicates[c.atom.predicate];
            if (p.route || p.prelude || p.linear() || c.atom.arguments.size() < 2 || !c.atom.arguments[1].is_variable() ||
                c.atom.arguments[1].variable != at)
                continue;
            d.labels.push_back({p.span, fmt::format("`{}` points to {}, and is not declared as a route", p.name, shown(at))});
            d.help = fmt::format("declare it `type route {}(...)`", p.name);
            diagnostics::Fix route = diagnostics::insert(p.span, "route ");
            route.title = fmt::format("Declare `{}` as a route", p.name);
            d.fixes.insert(d.fixes.begin(), std::move(route));
            return true;
        }
        return false;
    }

    // Whether facts of one predicate follow from those of others.
    bool follows_from(PredicateId p, std::set<PredicateId> others) const {
        for (std::size_t before = 0; before < others.size();) {
            before = others.size();
            for (const Rule& rule : program_.rules) {
                bool reads = false;
                each_atom(rule.body, [&](const Atom& a, bool) { reads = reads || others.contains(a.predicate); });
                if (reads) others.insert(rule.derives.begin(), rule.derives.end());
            }
        }
        return others.contains(p);
    }

    // A link that the program knows: the first of its own routes that there are without this rule, or `neighbor`.
    std::string link(std::string_view from, std::string_view to) const {
        const std::set<PredicateId> made(rule_.derives.begin(), rule_.derives.end());
        for (const PredicateId id : program_.predicates.ids()) {
            const Predicate& p = program_.predicates[id];
            if (!p.route || p.prelude || p.auxiliary || p.linear() || follows_from(id, made)) continue;
            // One that names a third catom may lead to that one as well.
            if (std::any_of(p.arguments.begin() + 2, p.arguments.end(), [](const Argument& a) { return a.type == Type::Node; })) continue;
            std::string text = fmt::format("{}({}, {}", p.name, from, to);
            for (std::size_t i = 2; i < p.arguments.size(); ++i) text += ", _";
            return text + ")";
        }
        return fmt::format("neighbor({}, {})", from, to);
    }

    void view() {
        MELD_EXPECT(rule_.heads.size() == 1 && rule_.heads[0].kind == Head::Kind::Fact, "view {} derives no fact", rule_.name);
        const Head& head = rule_.heads[0];
        rule_.site = head.atom.arguments[0].variable;
        const bool waits = program_.predicates[head.atom.predicate].complete_link.valid();
        if (waits) name_neighbours();
        Graph graph;
        links(rule_.body, graph);
        const Variables seen = reached(graph, rule_.site);
        bool any = false, met = false;
        for (const Clause& c : rule_.body)
            if (c.kind == Clause::Kind::Atom) {
                any = true;
                met = met || seen.contains(c.atom.arguments[0].variable);
            }
        if (any && !met) {
            auto& d = report_.add(Kind::HeadUnrelated, head.atom.arguments[0].span,
                                  fmt::format("the head is at {}, and no link of the body leads there", shown(rule_.site)));
            for (const Clause& c : rule_.body)
                if (c.kind == Clause::Kind::Atom) {
                    const VariableId at = c.atom.arguments[0].variable;
                    d.labels.push_back({c.atom.span, fmt::format("this fact is at {}", shown(at))});
                    head_needs_link(at, rule_.site, c, d);
                    break;
                }
            blame_pointer(rule_.body, rule_.site, d);
            if (program_.worlds == Worlds::Any && !waits) d.help += kFindsItself;
            return;
        }
        check_body(rule_.body, {});
        warn_of_far_route(head, graph, seen);
        if (!waits) return;
        if (const auto near = graph.find(rule_.site); near != graph.end())
            rule_.contributors.assign(near->second.begin(), near->second.end());
        std::erase(rule_.contributors, rule_.site);
    }

    // An aggregate that waits must know which neighbour a value comes from, even if the rule says neighbor(A, _).
    void name_neighbours() {
        for (Clause& c : rule_.body) {
            const bool link = c.kind == Clause::Kind::Atom && program_.predicates[c.atom.predicate].route && c.atom.arguments.size() > 1;
            if (!link || c.atom.arguments[1].op != Op::Anonymous) continue;
            Term& there = c.atom.arguments[1];
            there.op = Op::Variable;
            there.type = Type::Node;
            there.variable = rule_.variables.add({"_", there.span, Type::Node});
        }
    }

    // Facts are sent only between catoms that touch: a route over two links can be stored, but nothing is received along it.
    void warn_of_far_route(const Head& head, const Graph& graph, const Variables& seen) {
        const Predicate& p = program_.predicates[head.atom.predicate];
        if (!p.route || head.atom.arguments.size() < 2 || !head.atom.arguments[1].is_variable()) return;
        const VariableId to = head.atom.arguments[1].variable;
        const auto near = graph.find(rule_.site);
        if (to == rule_.site || !seen.contains(to) || (near != graph.end() && near->second.contains(to))) return;
        auto& d = report_.add(
            Kind::FarRoute, head.atom.span,
            fmt::format("{} may be more than one link away from {}: rules that follow `{}` see its facts only while the two touch",
                        shown(to), shown(rule_.site), p.name));
        d.labels.push_back({p.span, fmt::format("`{}` is declared as a route", p.name)});
        d.help = "leave out `route`, and join through the catom in between where its facts are needed";
    }

    void linear() {
        const Atom* first = nullptr;
        bool two = false;
        const auto consumed = [&](const Atom& a, bool negated) {
            if (!program_.predicates[a.predicate].linear()) return;
            if (first == nullptr) {
                first = &a;
            } else if (first->arguments[0].variable != a.arguments[0].variable && !two) {
                two = true;
                linear_elsewhere(*first, a, negated);
            }
        };
        each_atom(rule_.body, consumed);
        each_head(rule_.heads, [&](const Head& h) { each_atom(h.body, consumed); });
        if (two) return;
        MELD_CHECK(first != nullptr, "linear rule {} consumes nothing", rule_.name);
        rule_.site = first->arguments[0].variable;
        Graph graph;
        links(rule_.body, graph);
        check_body(rule_.body, {});
        around_ = {rule_.stands_for.empty() ? &rule_.body : &rule_.stands_for};
        check_heads(rule_.heads, graph);
    }

    void linear_elsewhere(const Atom& first, const Atom& a, bool negated) {
        const VariableId here = first.arguments[0].variable, there = a.arguments[0].variable;
        auto& d =
            report_.add(Kind::LinearElsewhere, a.span,
                        fmt::format("linear facts of two catoms, {} and {}, cannot be consumed in one step", shown(here), shown(there)));
        d.labels = {{first.span, fmt::format("this one is at {}", shown(here))}};
        const std::string& name = program_.predicates[a.predicate].name;
        if (negated || a.read_only) {
            d.help = fmt::format("a neighbour sees only persistent facts: keep one at {} while `{}` is there, and read that", shown(there),
                                 name);
            return;
        }
        const std::string from = written(there), to = written(here);
        if (first.predicate == a.predicate && !from.starts_with('@') && !to.starts_with('@')) {
            d.help = fmt::format(
                "two neighbours that both send their `{}` would miss each other: let a persistent fact say which of them gives\n"
                "its own away, and send that one first",
                name);
            return;
        }
        d.help =
            fmt::format("first send `{0}` to {1} by a rule of its own, which ends `-o {0}-here({2}, {3}, ...)`, and consume that there",
                        name, shown(here), to.empty() ? "A" : to, from.empty() ? "B" : from);
        const auto split = split_linear(program_, rule_, here, there);
        if (!split || rule_.select != Select::None) return;
        d.help = fmt::format("first send what is at `{}` over the link, then consume it at `{}`:\n`{}`\n`{}`\n`{}`", split->sent,
                             split->kept, split->declaration, split->send, split->consume);
        const std::string last = split->consume.substr(0, split->consume.size() - 1);
        d.fixes = {diagnostics::write(rule_.span, fmt::format("{}\n{}\n{}", split->declaration, split->send, last))};
        d.fixes.front().title = "Write it in two steps";
    }

    void check_heads(const std::vector<Head>& heads, const Graph& around) {
        for (const Head& h : heads) {
            Graph graph = around;
            if (h.kind == Head::Kind::Set && h.term.op == Op::Fresh) made_.insert(h.variable);
            if (h.kind != Head::Kind::Fact) {
                check_body(h.body, around);
                links(h.body, graph);
                around_.push_back(&h.body);
                check_heads(h.heads, graph);
                around_.pop_back();
                check_heads(h.others, h.kind == Head::Kind::Aggregate ? around : graph);
                continue;
            }
            const Predicate& p = program_.predicates[h.atom.predicate];
            const VariableId at = h.atom.arguments[0].variable;
            if (at == rule_.site) continue;
            if (made_.contains(at) && program_.worlds != Worlds::Any) {
                finds_way_ = true;
                continue;
            }
            if (made_.contains(at)) {
                if (refused_.insert(at))
                    report_
                        .add(Kind::HeadUnrelated, h.atom.arguments[0].span,
                             fmt::format("{} is a new value, and there is no catom at it", shown(at)))
                        .help =
                        "to make a catom, request the action `create`; only in a world with `lattice = \"graph\"` would this make a node "
                        "(--graph)";
                continue;
            }
            if (!refused_.insert(at)) continue;
            const bool linked = reached(graph, rule_.site).contains(at);
            finds_way_ = finds_way_ || !linked;
            // In a graph it finds its way.
            if (linked || program_.worlds != Worlds::Any) {
                if (!linked && p.sends.valid()) note_sent(program_.predicates[p.sends], h.atom, at);
                refused_.erase(at);
                continue;
            }
            auto& d = report_.add(Kind::HeadUnrelated, h.atom.arguments[0].span,
                                  fmt::format("the head is at {}, and no link of the body leads there", shown(at)));
            if (!rule_.stands_for.empty())
                d.labels.push_back({first_fact().atom.span, fmt::format("this fact is at {}", shown(rule_.site))});
            head_needs_link(rule_.site, at, first_fact(), d);
            for (const std::vector<Clause>* part : around_) blame_pointer(*part, at, d);
            d.help += kFindsItself;
        }
    }

    // A view elsewhere holds exactly as long as its body.
    void note_sent(const Predicate& view, const Atom& head, VariableId at) {
        if (view.kind == PredicateKind::Action) return;
        auto& d = report_.add(Kind::SentView, head.arguments[0].span,
                              fmt::format("`{}` is sent to {}, where it stays: no link of the body leads there", view.name, shown(at)));
        blame_pointer(rule_.stands_for, at, d);
        if (d.help.empty()) d.help = "to have it only while the body holds, join the two by a route";
    }

    void head_needs_link(VariableId from, VariableId to, const Clause& before, diagnostics::Diagnostic& d) const {
        const std::string here = written(from), there = written(to);
        if (here.empty() || there.empty()) {
            d.help = "a head must be at a catom of the body or its neighbour";
            return;
        }
        const std::string added = link(here, there);
        d.help = fmt::format("add `{}`", added);
        suggest_link(added, before, nullptr, d);
    }
    // Where a link for a head goes: before the first fact of the innermost body around it.
    const Clause& first_fact() const {
        static const Clause none;
        const std::vector<Clause>& body = *around_.back();
        const auto fact = std::find_if(body.begin(), body.end(), [](const Clause& c) { return c.kind == Clause::Kind::Atom; });
        return fact == body.end() ? none : *fact;
    }

    const Program& program_;
    Rule& rule_;
    diagnostics::Reporter& report_;
    bool finds_way_ = false;
    Variables refused_;
    Variables made_;                                  // By `exists`.
    std::vector<const std::vector<Clause>*> around_;  // The bodies around a head.
};

// An aggregate waits for neighbours, and none of its rules follows a link to one.
void refuse_silent_neighbours(const Program& program, diagnostics::Reporter& report) {
    for (const PredicateId id : program.predicates.ids()) {
        const Predicate& p = program.predicates[id];
        if (!p.complete_link.valid() || p.refused) continue;
        bool made = false, heard = false;
        for (const Rule& rule : program.rules) {
            each_head(rule.heads, [&](const Head& h) { made = made || (h.kind == Head::Kind::Fact && h.atom.predicate == id); });
            heard = heard || rule.refused || (!rule.linear && rule.heads[0].atom.predicate == id && !rule.contributors.empty());
        }
        if (!made || heard) continue;
        auto& d = report.add(Kind::BadAggregate, p.span,
                             fmt::format("`{}` waits for its neighbours, and no rule for it follows a link to one", p.name));
        for (const Rule& rule : program.rules)
            each_head(rule.heads, [&](const Head& h) {
                if (h.kind == Head::Kind::Fact && h.atom.predicate == id)
                    d.labels.push_back({h.atom.span, "this comes from the catom itself"});
            });
        const Predicate& link = program.predicates[p.complete_link];
        d.help = fmt::format("read the neighbour in a view: `{}(A, ...) :- {}({}), ...`", p.name, link.name,
                             p.complete_outgoing ? "A, B" : "B, A");
    }
}

}  // namespace

// Whether some rule makes facts at a node that no link leads to.
static bool find_ways(const Program& program) {
    diagnostics::Reporter unheard;
    return std::ranges::any_of(program.rules, [&](Rule rule) {
        Sites sites(program, rule, unheard);
        sites.run();
        return sites.finds_way();
    });
}

void find_sites(Program& program, diagnostics::Reporter& report) {
    const bool finds_ways = find_ways(program);
    program.own_graph = runs_in_own_graph(program, finds_ways);
    if (program.worlds == Worlds::Undecided) program.worlds = finds_ways && program.own_graph ? Worlds::Graphs : Worlds::Any;
    for (Rule& rule : program.rules) {
        const std::size_t errors = report.error_count();
        Sites sites(program, rule, report);
        sites.run();
        rule.refused = report.error_count() > errors;
    }
    refuse_silent_neighbours(program, report);
}

}  // namespace meld::check
