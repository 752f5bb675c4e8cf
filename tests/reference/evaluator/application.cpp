#include "tests/reference/evaluator/application.h"

#include <algorithm>
#include <map>
#include <set>

#include "tests/reference/evaluator/model.h"

namespace meld::reference {

using check::Clause;
using check::Head;
using check::Op;
using check::Select;
using check::VariableId;

Application::Application(const check::Rule& rule, const Sight& sight, std::vector<Bag>& linear)
    : program_(*sight.scene.program),
      rule_(rule),
      sight_{sight.scene, sight.facts, &linear, sight.before, sight.links_before, sight.site},
      linear_(linear) {}

bool Application::run(std::int64_t site) {
    Environment env(rule_.variables.count());
    env[rule_.site.index()] = value_of(site);
    const std::vector<Match> all = matches(rule_.body, env, rule_.select == Select::None ? Which::First : Which::All);
    if (all.empty() || failed) return false;
    const Match& chosen = *select(all);
    consume(chosen.taken);
    heads(rule_.heads, chosen.env, {&rule_.body});
    return true;
}

// ---- bodies

std::vector<Application::Match> Application::matches(const std::vector<Clause>& body, const Environment& env, Which which) {
    Solver solver(sight_);
    std::vector<Match> all;
    Environment inner = env;
    solver.solve(body, inner, [&] {
        all.push_back({inner, solver.taken()});
        return which == Which::First;
    });
    failed = failed || solver.failed();
    return all;
}

// Of equals the first.
const Application::Match* Application::select(const std::vector<Match>& all) {
    if (rule_.select == Select::Random) return &all[sight_.scene.chance->next() % all.size()];
    const Match* best = &all[0];
    for (const Match& m : all) {
        if (rule_.select == Select::None) break;
        const Value &value = *m.env[rule_.selected.index()], &least = *best->env[rule_.selected.index()];
        if (rule_.select == Select::Ascending ? value < least : least < value) best = &m;
    }
    return best;
}

void Application::consume(const std::vector<Taken>& taken) {
    for (const Taken& t : taken) {
        Bag& bag = linear_[t.predicate.index()];
        bag.erase(bag.find(t.row));
    }
}

// ---- heads

void Application::heads(const std::vector<Head>& all, const Environment& env, const Bodies& bodies) {
    for (const Head& h : all) {
        if (failed) return;
        switch (h.kind) {
            case Head::Kind::Fact:
                fact(h, env, bodies);
                break;
            case Head::Kind::Aggregate:
                aggregate(h, env, bodies);
                break;
            case Head::Kind::Comprehension: {
                Bodies inner = bodies;
                inner.push_back(&h.body);
                each_match(h, env, [&](const Environment& match) { heads(h.heads, match, inner); });
                break;
            }
            case Head::Kind::If: {
                const std::optional<Value> truth = evaluate(sight_.scene, h.term, env);
                failed = failed || !truth;
                if (truth) heads(truth->truth() ? h.heads : h.others, env, bodies);
                break;
            }
            case Head::Kind::Set: {
                Environment inner = env;
                if (makes_node(h)) {
                    born.push_back(static_cast<std::int64_t>(sight_.scene.chance->next_node()));
                    inner[h.variable.index()] = value_of(born.back());
                    born_at_.insert(h.variable);
                } else {
                    inner[h.variable.index()] = evaluate(sight_.scene, h.term, env);
                }
                heads(h.heads, inner, bodies);
            }
        }
    }
}

// Whether some head, also one that is not reached, is at the new value.
bool Application::makes_node(const Head& h) const {
    if (h.term.op != Op::Fresh || rule_.initial_fact || program_.worlds != check::Worlds::Graphs) return false;
    bool any = false;
    const auto note = [&](const Head& inner) {
        any = any || (inner.kind == Head::Kind::Fact && inner.atom.arguments[0].variable == h.variable);
    };
    check::each_head(h.heads, note);
    return any;
}

void Application::fact(const Head& h, const Environment& env, const Bodies& bodies) {
    std::optional<Row> row = head_row(sight_.scene, h.atom, env);
    const std::optional<Value> delay = h.delay.op == Op::Anonymous ? value_of(std::int64_t{0}) : evaluate(sight_.scene, h.delay, env);
    failed = failed || !row || !delay;
    if (failed) return;
    bool far = false;
    std::vector<std::int64_t> catoms = way(h.atom.arguments[0].variable, env, bodies, far);
    made.push_back(
        {h.atom.predicate, std::move(*row), std::move(catoms), delay->integer(), far, born_at_.contains(h.atom.arguments[0].variable)});
}

template <class Visit>
void Application::each_match(const Head& h, const Environment& env, const Visit& visit) {
    bool consumes = false;
    check::each_atom(h.body, [&](const check::Atom& a, bool negated) {
        consumes = consumes || (!negated && !a.read_only && program_.predicates[a.predicate].linear());
    });
    std::vector<Match> found = matches(h.body, env, consumes ? Which::First : Which::All);
    while (!found.empty() && !failed) {
        for (const Match& m : found) {
            consume(m.taken);
            visit(m.env);
        }
        found = consumes ? matches(h.body, env, Which::First) : std::vector<Match>();
    }
}

void Application::aggregate(const Head& h, const Environment& env, const Bodies& bodies) {
    Bodies inner = bodies;
    inner.push_back(&h.body);
    std::vector<Values> values(h.aggregates.size());
    each_match(h, env, [&](const Environment& match) {
        for (std::size_t i = 0; i < h.aggregates.size(); ++i)
            values[i].push_back(h.aggregates[i].each.valid() ? *match[h.aggregates[i].each.index()] : value_of(std::int64_t{1}));
        heads(h.heads, match, inner);
    });
    Environment last = env;
    for (std::size_t i = 0; i < h.aggregates.size(); ++i) {
        const check::HeadAggregate& f = h.aggregates[i];
        FoldRule rule{.aggregate = f.aggregate, .type = rule_.variables[f.each.valid() ? f.each : f.result].type, .function = f.function};
        if (f.parameter.op != Op::Anonymous) rule.parameter = evaluate(sight_.scene, f.parameter, env);
        const Folded folded = fold(sight_.scene, rule, values[i]);
        failed = failed || folded.failed;
        if (failed || !folded.value) return;
        last[f.result.index()] = folded.value;
    }
    heads(h.others, last, bodies);
}

// ---- where facts go

std::vector<std::int64_t> Application::way(VariableId goal, const Environment& env, const Bodies& bodies, bool& far) const {
    if (goal == rule_.site) return {};
    std::map<VariableId, std::set<VariableId>> links;
    for (const std::vector<Clause>* body : bodies)
        for (const Clause& c : *body) {
            if (c.kind != Clause::Kind::Atom || !program_.predicates[c.atom.predicate].route || !c.atom.arguments[1].is_variable())
                continue;
            const VariableId a = c.atom.arguments[0].variable, b = c.atom.arguments[1].variable;
            links[a].insert(b);
            links[b].insert(a);
        }
    // Breadth first.
    std::map<VariableId, std::vector<VariableId>> ways{{rule_.site, {}}};
    std::vector<VariableId> reached{rule_.site};
    for (std::size_t i = 0; i < reached.size() && !ways.contains(goal); ++i)
        for (const VariableId next : links[reached[i]]) {
            if (ways.contains(next)) continue;
            ways[next] = ways[reached[i]];
            ways[next].push_back(next);
            reached.push_back(next);
        }
    std::vector<std::int64_t> catoms;
    for (const VariableId v : ways[goal]) catoms.push_back(env[v.index()]->integer());
    // A place that no link of the bodies leads to is next to the execution site, or the fact is dropped; but where facts go far.
    far = catoms.empty();
    if (catoms.empty()) catoms.push_back(env[goal.index()]->integer());
    return catoms;
}

}  // namespace meld::reference
