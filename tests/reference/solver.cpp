#include "solver.h"

#include <algorithm>

namespace meld::reference {

using check::Atom;
using check::Clause;
using check::Op;
using check::Term;
using check::WorldSource;

namespace {

bool is_neighbor(const check::Predicate& p) { return p.world == WorldSource::Neighbor || p.world == WorldSource::NeighborPort; }

void unbind(Environment& env, std::vector<std::size_t>& bound, std::size_t keep) {
    for (; bound.size() > keep; bound.pop_back()) env[bound.back()].reset();
}

}  // namespace

bool Solver::solve(const std::vector<Clause>& body, Environment& env, const std::function<bool()>& found) {
    Clauses open;
    for (const Clause& c : body) open.push_back(&c);
    return atoms(std::move(open), env, found);
}

bool Solver::readable(const Atom& a, const Environment& env) const {
    for (std::size_t i = 1; i < a.arguments.size(); ++i)
        if (!a.arguments[i].is_variable() && a.arguments[i].op != Op::Anonymous && !all_bound(a.arguments[i], env)) return false;
    if (env[a.arguments[0].variable.index()]) return true;
    return program_.predicates[a.predicate].route && a.arguments[1].is_variable() && env[a.arguments[1].variable.index()];
}

Solver::Clauses::const_iterator Solver::next_atom(const Clauses& open, const Environment& env) const {
    const auto is_atom = [](const Clause* c) { return c->kind == Clause::Kind::Atom; };
    const auto first = std::find_if(open.begin(), open.end(), [&](const Clause* c) { return is_atom(c) && readable(c->atom, env); });
    return first != open.end() ? first : std::find_if(open.begin(), open.end(), is_atom);
}

bool Solver::atoms(Clauses open, Environment& env, const std::function<bool()>& found) {
    const auto next = next_atom(open, env);
    if (next == open.end()) return tests(std::move(open), env, found);
    const Atom& atom = (*next)->atom;
    open.erase(next);
    const bool consumes = program_.predicates[atom.predicate].linear() && !atom.read_only && negations_ == 0;
    std::vector<std::size_t> bound;
    for (const Row& row : candidates(atom, env)) {
        const std::size_t deferred = deferred_.size();
        bool stop = false;
        if (match(atom, row, env, bound)) {
            if (consumes) taken_.push_back({atom.predicate, row});
            stop = atoms(open, env, found);
            if (consumes) taken_.pop_back();
        }
        deferred_.resize(deferred, {});
        unbind(env, bound, 0);
        if (stop) return true;
    }
    return false;
}

bool Solver::tests(Clauses open, Environment& env, const std::function<bool()>& found) {
    std::vector<std::size_t> bound;
    bool satisfied = run_tests(open, env, bound);
    for (const Deferred& d : deferred_) {
        const std::optional<Value> value = satisfied ? evaluate(program_, *d.term, env) : std::nullopt;
        failed_ = failed_ || (satisfied && !value);
        satisfied = satisfied && value && *value == d.value;
    }
    for (const Clause* c : open) satisfied = satisfied && nothing_satisfies(c->inner, env);
    const bool stop = satisfied && found();
    unbind(env, bound, 0);
    return stop;
}

// Tests in the order of the text, those first whose variables are known; an equality gives a variable its value. Leaves the
// negations in `open`.
bool Solver::run_tests(Clauses& open, Environment& env, std::vector<std::size_t>& bound) {
    const auto ready = [&](const Clause* c) {
        if (c->kind != Clause::Kind::Test) return false;
        if (all_bound(c->test, env)) return true;
        if (c->test.op != Op::Equal) return false;
        for (const std::size_t side : {0u, 1u})
            if (c->test.operands[side].is_variable() && all_bound(c->test.operands[1 - side], env)) return true;
        return false;
    };
    for (auto next = std::find_if(open.begin(), open.end(), ready); next != open.end(); next = std::find_if(open.begin(), open.end(), ready)) {
        const Term& test = (*next)->test;
        open.erase(next);
        if (all_bound(test, env)) {
            if (!holds(test, env)) return false;
            continue;
        }
        const std::size_t side = all_bound(test.operands[0], env) ? 1 : 0;
        const std::size_t variable = test.operands[side].variable.index();
        env[variable] = evaluate(program_, test.operands[1 - side], env);
        if (!env[variable]) {
            failed_ = true;
            return false;
        }
        bound.push_back(variable);
    }
    return true;
}

bool Solver::holds(const Term& test, const Environment& env) {
    const std::optional<Value> value = evaluate(program_, test, env);
    failed_ = failed_ || !value;
    return value && value->truth();
}

bool Solver::nothing_satisfies(const std::vector<Clause>& inner, Environment& env) {
    std::vector<Deferred> outside;
    std::swap(outside, deferred_);
    ++negations_;
    const bool any = solve(inner, env, [] { return true; });
    --negations_;
    std::swap(outside, deferred_);
    return !any;
}

bool Solver::match(const Atom& atom, const Row& row, Environment& env, std::vector<std::size_t>& bound) {
    for (std::size_t i = 0; i < row.size(); ++i) {
        const Term& t = atom.arguments[i];
        if (t.op == Op::Anonymous) continue;
        if (t.is_variable() && !env[t.variable.index()]) {
            env[t.variable.index()] = row[i];
            bound.push_back(t.variable.index());
        } else if (all_bound(t, env)) {
            const std::optional<Value> value = evaluate(program_, t, env);
            failed_ = failed_ || !value;
            if (!value || *value != row[i]) return false;
        } else {
            deferred_.push_back({&t, row[i]});
        }
    }
    return true;
}

std::vector<Row> Solver::candidates(const Atom& atom, const Environment& env) const {
    const check::Predicate& p = program_.predicates[atom.predicate];
    const std::optional<Value> place = env[atom.arguments[0].variable.index()];
    if (is_neighbor(p)) return linked(atom, place, env);
    const std::size_t index = atom.predicate.index();
    std::vector<Row> rows;
    if (p.linear()) {
        const auto [first, last] = at_catom((*linear_)[index], place->integer());
        rows.assign(first, last);
        for (const Taken& t : taken_)
            if (t.predicate == atom.predicate) rows.erase(std::find(rows.begin(), rows.end(), t.row));
        return rows;
    }
    const Rows& all = p.world == WorldSource::None ? facts_[index] : scene_.world[index];
    const auto [first, last] = place ? at_catom(all, place->integer()) : std::pair(all.begin(), all.end());
    rows.assign(first, last);
    return rows;
}

std::vector<Row> Solver::linked(const Atom& atom, const std::optional<Value>& place, const Environment& env) const {
    const bool with_port = atom.arguments.size() > 2;
    std::vector<Row> rows;
    const auto add = [&](std::int64_t from, std::int64_t to, int port) {
        rows.push_back({value_of(from), value_of(to)});
        if (with_port) rows.back().push_back(value_of(std::int64_t{port}));
    };
    if (place) {
        if (const auto found = scene_.links.find(place->integer()); found != scene_.links.end())
            for (const Link& link : found->second) add(place->integer(), link.other, link.port);
        return rows;
    }
    const check::Term& end = atom.arguments[1];
    const Value* other = end.is_variable() && env[end.variable.index()] ? &*env[end.variable.index()] : nullptr;
    for (const auto& [catom, links] : scene_.links) {
        if (other != nullptr && other->integer() != catom) continue;
        for (const Link& link : links) add(link.other, catom, link.back);
    }
    return rows;
}

}  // namespace meld::reference
