#include "tests/reference/evaluator/bodies.h"

#include <algorithm>
#include <set>

#include "tests/reference/evaluator/solver.h"

namespace meld::reference {

using check::Atom;
using check::Clause;
using check::Head;
using check::Op;
using check::Rule;
using check::Term;
using check::VariableId;

namespace {

Clause test_of(Term term) {
    Clause out{.kind = Clause::Kind::Test};
    out.test = std::move(term);
    return out;
}

void add_heads(const Rule& rule, const std::vector<Head>& heads, const Clauses& clauses, bool of_results, PredicateId p,
               std::vector<HeadOf>& out) {
    for (const Head& h : heads) {
        if (h.kind == Head::Kind::Fact && h.atom.predicate == p) out.push_back({&rule, &h, clauses, of_results});
        Clauses within = clauses, behind = clauses;
        within.insert(within.end(), h.body.begin(), h.body.end());
        if (h.kind == Head::Kind::If) {
            within.push_back(test_of(h.term));
            Term otherwise{.op = Op::Not, .type = check::Type::Bool};
            otherwise.operands = {h.term};
            behind.push_back(test_of(std::move(otherwise)));
        }
        if (h.kind == Head::Kind::Set && h.term.op != Op::Fresh) {
            Term variable{.op = Op::Variable, .type = rule.variables[h.variable].type};
            variable.variable = h.variable;
            Term same{.op = Op::Equal, .type = check::Type::Bool};
            same.operands = {std::move(variable), h.term};
            within.push_back(test_of(std::move(same)));
        }
        add_heads(rule, h.heads, within, of_results, p, out);
        add_heads(rule, h.others, behind, of_results || h.kind == Head::Kind::Aggregate, p, out);
    }
}

bool is_link(const check::Predicate& p) { return p.world == check::WorldSource::Neighbor || p.world == check::WorldSource::NeighborPort; }

}  // namespace

std::vector<HeadOf> heads_of(const check::Program& program, PredicateId p, RuleKind kind) {
    std::vector<HeadOf> out;
    for (const Rule& rule : program.rules)
        if (rule.linear == (kind == RuleKind::Linear)) add_heads(rule, rule.heads, rule.body, false, p, out);
    return out;
}

bool beyond_states(const Term& term) {
    bool any = false;
    check::each_subterm(term, [&](const Term& t) {
        any = any || t.op == Op::Now || t.op == Op::Ticks || t.op == Op::Due || t.op == Op::Fresh ||
              (t.op == Op::Library && t.text == "randint");
    });
    return any;
}

bool beyond_states(const Clauses& body) {
    return std::ranges::any_of(body, [](const Clause& c) {
        return c.kind == Clause::Kind::Delta || beyond_states(c.test) || beyond_states(c.inner) ||
               std::ranges::any_of(c.atom.arguments, [](const Term& t) { return beyond_states(t); });
    });
}

Bodies::Ages Bodies::ages(const check::Program& program, const Rule& rule, const Clauses& clauses) {
    // How many links away each catom is: what a link joins to one of the last round is one further.
    std::map<VariableId, std::int64_t> away{{rule.site, 0}};
    for (std::int64_t round = 1; round <= static_cast<std::int64_t>(rule.variables.count()); ++round) {
        std::map<VariableId, std::int64_t> more;
        check::each_atom(clauses, [&](const Atom& a, bool) {
            const check::Predicate& p = program.predicates[a.predicate];
            if ((!p.route && !is_link(p)) || a.arguments.size() < 2 || !a.arguments[1].is_variable()) return;
            const VariableId from = a.arguments[0].variable, to = a.arguments[1].variable;
            if (away.contains(from) && !away.contains(to)) more.emplace(to, round);
            if (away.contains(to) && !away.contains(from)) more.emplace(from, round);
        });
        away.insert(more.begin(), more.end());
    }
    const auto of = [&](const Term& t) { return t.is_variable() && away.contains(t.variable) ? away.at(t.variable) : 0; };
    Ages out;
    check::each_atom(clauses, [&](const Atom& a, bool) {
        const check::Predicate& p = program.predicates[a.predicate];
        const bool link = is_link(p) && a.arguments[1].is_variable();
        // A link is sensed at both of its ends.
        out.read[&a] = link ? std::min(of(a.arguments[0]), of(a.arguments[1])) : of(a.arguments[0]);
        const auto known = [&](const Term& t) { return t.is_variable() && away.contains(t.variable); };
        if (p.route && known(a.arguments[0]) && known(a.arguments[1]) && of(a.arguments[0]) != of(a.arguments[1]))
            out.linked[&a] = std::min(of(a.arguments[0]), of(a.arguments[1]));
    });
    return out;
}

namespace {

// In this order a catom's links are looked at, so lists of matches have it.
std::vector<Row> by_port(const Moment& moment, const Atom& atom, std::int64_t place) {
    std::vector<Row> out;
    if (!moment.scene.links.contains(place)) return out;
    for (const Link& link : moment.scene.links.at(place)) {
        out.push_back({value_of(place), value_of(link.other)});
        if (atom.arguments.size() > 2) out.back().push_back(value_of(std::int64_t{link.port}));
    }
    return out;
}

}  // namespace

bool Bodies::solve(const Search& s, const std::function<bool(const Environment&)>& found) const {
    const Moment& now = past_.at(s.when.tick);
    Sight sight{now.scene, now.facts};
    sight.rows = [&](const Atom& atom, const std::optional<Value>& place) {
        std::vector<Row> out;
        const auto add = [&](const Rows& rows) {
            const auto [first, last] = place ? at_catom(rows, place->integer()) : std::pair(rows.begin(), rows.end());
            out.insert(out.end(), first, last);
        };
        if (const auto named = s.named.find(&atom); named != s.named.end()) {
            add(named->second);
            return out;
        }
        const std::int64_t away = s.when.spread ? s.ages.at(&atom) : 0, tick = s.when.tick - away;
        // Before the first tick no catom has told others anything.
        if (!past_.has(tick) || (away > 0 && tick == 0)) return out;
        const Moment& then = past_.at(tick);
        if (place && is_link(past_.program().predicates[atom.predicate])) return by_port(then, atom, place->integer());
        add(then.facts[atom.predicate.index()]);
        if (const auto linked = s.ages.linked.find(&atom); linked != s.ages.linked.end()) {
            const auto& links = past_.at(s.when.tick - (s.when.spread ? linked->second : 0)).scene.links;
            std::erase_if(out, [&](const Row& row) {
                const auto of = links.find(row[0].integer());
                return of == links.end() || std::ranges::find(of->second, row[1].integer(), &Link::other) == of->second.end();
            });
        }
        return out;
    };
    Environment env = s.env;
    env.resize(s.rule.variables.count());
    Solver solver(sight);
    return solver.solve(s.clauses, env, [&] { return found(env); });
}

Rule Bodies::named(const Rule& rule, const Environment& env) const {
    Rule out = rule;
    for (const VariableId v : out.variables.ids())
        if (v.index() < env.size() && env[v.index()]) out.variables[v].name = reference::print(out.variables[v].type, *env[v.index()]);
    return out;
}

std::string Bodies::print(const Rule& rule, const Environment& env, const Clause& clause) const {
    return check::print(past_.program(), named(rule, env), clause);
}
std::string Bodies::print(const Rule& rule, const Environment& env, const Atom& atom) const {
    return check::print(past_.program(), named(rule, env), atom);
}
std::string Bodies::print(const Rule& rule, const Environment& env, const Clauses& clauses) const {
    std::string out;
    for (const Clause& c : clauses) out += (out.empty() ? "" : ", ") + print(rule, env, c);
    return out;
}

bool Bodies::says_nothing(const Rule& rule, const Environment& env, const Term& test) const {
    if (test.op != Op::Equal) return false;
    const Rule own = named(rule, env);
    return check::print(past_.program(), own, test.operands[0]) == check::print(past_.program(), own, test.operands[1]);
}

namespace {

// The variables that a body has outside of its parts: another one of the same name may be within them.
std::set<VariableId> outside(const HeadOf& h) {
    std::set<VariableId> out{h.rule->site};
    const auto add = [&](const Term& term) { check::each_free_use(term, [&](const Term& t) { out.insert(t.variable); }); };
    for (const Term& t : h.head->atom.arguments) add(t);
    for (const Clause& c : h.clauses) {
        for (const Term& t : c.atom.arguments) add(t);
        if (c.kind != Clause::Kind::Aggregate) add(c.test);
        if (c.variable.valid()) out.insert(c.variable);
        if (c.position.valid()) out.insert(c.position);
    }
    return out;
}

}  // namespace

std::optional<Environment> Bodies::environment(const HeadOf& head, const std::map<std::string, std::string>& with) const {
    const Rule& rule = *head.rule;
    const std::set<VariableId> own = outside(head);
    Environment env(rule.variables.count());
    for (const auto& [name, text] : with) {
        const auto v = std::ranges::find_if(own, [&](VariableId id) { return rule.variables[id].name == name; });
        if (v == own.end()) return std::nullopt;
        const std::optional<Value> value = parse_value(rule.variables[*v].type, text);
        if (!value) return std::nullopt;
        env[v->index()] = *value;
    }
    return env;
}

}  // namespace meld::reference
