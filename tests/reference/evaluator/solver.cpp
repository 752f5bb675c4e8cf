#include "tests/reference/evaluator/solver.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace meld::reference {

using check::Aggregate;
using check::Atom;
using check::Clause;
using check::Op;
using check::Term;
using check::WorldSource;

namespace {

bool is_pattern(const Term& t) { return t.op == Op::List || t.op == Op::Cons || t.op == Op::Struct || t.op == Op::Tuple; }

}  // namespace

class Solver::Mark {
  public:
    Mark(Solver& solver, Environment& env) : solver_(solver), env_(env), bound_(solver.bound_.size()), deferred_(solver.deferred_.size()) {}
    ~Mark() {
        for (; solver_.bound_.size() > bound_; solver_.bound_.pop_back()) env_[solver_.bound_.back()].reset();
        solver_.deferred_.resize(deferred_, {});
    }
    Mark(const Mark&) = delete;
    Mark& operator=(const Mark&) = delete;

  private:
    Solver& solver_;
    Environment& env_;
    std::size_t bound_, deferred_;
};

bool Solver::solve(const std::vector<Clause>& body, Environment& env, const Found& found) {
    Clauses open;
    for (const Clause& c : body) open.push_back(&c);
    return step(std::move(open), env, found);
}

bool Solver::step(Clauses open, Environment& env, const Found& found) {
    Next next = next_test(open, env);
    if (next == open.end()) next = next_choice(open, env);
    if (next == open.end())
        next = std::find_if(open.begin(), open.end(), [](const Clause* c) { return c->kind == Clause::Kind::Aggregate; });
    if (next == open.end()) return finish(open, env, found);
    const Clause& clause = **next;
    open.erase(next);
    switch (clause.kind) {
        case Clause::Kind::Test:
            return try_test(clause, std::move(open), env, found);
        case Clause::Kind::Atom:
            return try_atom(clause.atom, std::move(open), env, found);
        case Clause::Kind::Delta:
            return try_change(clause, std::move(open), env, found);
        case Clause::Kind::Element:
            return try_elements(clause, std::move(open), env, found);
        case Clause::Kind::Aggregate:
            return try_aggregate(clause, std::move(open), env, found);
        default:
            return false;
    }
}

// ---- tests: in the order of the text, those first whose variables are known; an equality binds

Solver::Next Solver::next_test(const Clauses& open, const Environment& env) const {
    return std::find_if(open.begin(), open.end(), [&](const Clause* c) {
        if (c->kind != Clause::Kind::Test) return false;
        if (all_bound(c->test, env)) return true;
        if (c->test.op != Op::Equal) return false;
        for (const std::size_t side : {0u, 1u}) {
            const Term &target = c->test.operands[side], &value = c->test.operands[1 - side];
            if ((target.is_variable() || is_pattern(target)) && all_bound(value, env)) return true;
        }
        return false;
    });
}

bool Solver::try_test(const Clause& clause, Clauses rest, Environment& env, const Found& found) {
    const Mark mark(*this, env);
    const Term& test = clause.test;
    if (all_bound(test, env)) {
        const std::optional<Value> truth = value(test, env);
        return truth && truth->truth() && step(std::move(rest), env, found);
    }
    const std::size_t side = all_bound(test.operands[0], env) ? 1 : 0;
    const std::optional<Value> is = value(test.operands[1 - side], env);
    return is && unify(test.operands[side], *is, env) && step(std::move(rest), env, found);
}

// ---- choices: facts, those that have changed, and elements

Solver::Next Solver::next_choice(const Clauses& open, const Environment& env) const {
    const auto first = std::find_if(open.begin(), open.end(), [&](const Clause* c) {
        return (c->kind == Clause::Kind::Atom && readable(c->atom, env)) ||
               ((c->kind == Clause::Kind::Element || c->kind == Clause::Kind::Delta) && all_bound(c->test, env));
    });
    return first != open.end() ? first
                               : std::find_if(open.begin(), open.end(), [](const Clause* c) { return c->kind == Clause::Kind::Atom; });
}

bool Solver::readable(const Atom& a, const Environment& env) const {
    for (std::size_t i = 1; i < a.arguments.size(); ++i)
        if (!a.arguments[i].is_variable() && !is_pattern(a.arguments[i]) && a.arguments[i].op != Op::Anonymous &&
            !all_bound(a.arguments[i], env))
            return false;
    if (env[a.arguments[0].variable.index()]) return true;
    return program_.predicates[a.predicate].route && a.arguments[1].is_variable() && env[a.arguments[1].variable.index()];
}

bool Solver::try_atom(const Atom& atom, Clauses rest, Environment& env, const Found& found) {
    // What a question or a judge names is a set, in which equal facts are one.
    const bool uses = program_.predicates[atom.predicate].linear() && !inside_ && !sight_.rows;
    std::size_t at = 0;
    for (const Row& row : candidates(atom, env)) {
        const std::size_t place = at++;
        if (uses && !is_free(atom, place)) continue;
        const Mark mark(*this, env);
        if (!match(atom, row, env)) continue;
        if (uses) matched_.push_back({atom.predicate, row, place, !atom.read_only});
        const bool stop = step(rest, env, found);
        if (uses) matched_.pop_back();
        if (stop) return true;
    }
    return false;
}

// What the rule consumes, no other atom of the body matches; what it only reads, several may.
bool Solver::is_free(const Atom& atom, std::size_t at) const {
    return std::ranges::none_of(
        matched_, [&](const Taken& m) { return m.predicate == atom.predicate && m.at == at && (m.consumed || !atom.read_only); });
}

std::vector<Taken> Solver::taken() const {
    std::vector<Taken> taken;
    std::ranges::copy_if(matched_, std::back_inserter(taken), [](const Taken& m) { return m.consumed; });
    return taken;
}

bool Solver::try_change(const Clause& clause, Clauses rest, Environment& env, const Found& found) {
    const std::optional<Value> limit = value(clause.test, env);
    if (!limit) return false;
    const double bound = limit->is_real() ? limit->real() : static_cast<double>(limit->integer());
    for (const Row& row : candidates(clause.atom, env)) {
        const Mark mark(*this, env);
        if (!match(clause.atom, row, env)) continue;
        const double change = change_of(clause, row);
        const bool fits = clause.compare == Op::Greater        ? change > bound
                          : clause.compare == Op::GreaterEqual ? change >= bound
                          : clause.compare == Op::Less         ? change < bound
                          : clause.compare == Op::LessEqual    ? change <= bound
                          : clause.compare == Op::Equal        ? change == bound
                                                               : change != bound;
        if (fits && step(rest, env, found)) return true;
    }
    return false;
}

// From the nearest value that there was beside the same other arguments; of none, without bound.
double Solver::change_of(const Clause& clause, const Row& row) const {
    if (sight_.before == nullptr) return 0;
    std::size_t at = 0;
    while (!clause.atom.arguments[at].is_variable() || clause.atom.arguments[at].variable != clause.variable) ++at;
    double least = std::numeric_limits<double>::infinity();
    for (Row other : (*sight_.before)[clause.atom.predicate.index()]) {
        const Value was = std::exchange(other[at], row[at]);
        if (other != row) continue;
        const double change =
            was.is_real() ? std::fabs(was.real() - row[at].real()) : std::fabs(static_cast<double>(was.integer() - row[at].integer()));
        least = std::min(least, change);
    }
    return least;
}

bool Solver::try_elements(const Clause& clause, Clauses rest, Environment& env, const Found& found) {
    const std::optional<Value> list = value(clause.test, env);
    if (!list) return false;
    std::int64_t position = 0;
    for (const Value& element : list->items()) {
        const Mark mark(*this, env);
        if (clause.position.valid()) bind(clause.position.index(), value_of(position++), env);
        std::optional<Value>& variable = env[clause.variable.index()];
        if (variable && *variable != element) continue;
        if (!variable) bind(clause.variable.index(), element, env);
        if (step(rest, env, found)) return true;
    }
    return false;
}

// ---- what looks at all the ways to satisfy an inner body

bool Solver::try_aggregate(const Clause& clause, Clauses rest, Environment& env, const Found& found) {
    Values values;
    Solver inner(sight_);
    inner.inside_ = true;
    inner.solve(clause.inner, env, [&] {
        const std::optional<Value> one = clause.aggregate == Aggregate::Count ? value_of(std::int64_t{1}) : inner.value(clause.test, env);
        if (one) values.push_back(*one);
        return false;
    });
    FoldRule rule{.aggregate = clause.aggregate, .type = clause.test.type, .function = clause.fold};
    if (clause.parameter.op != Op::Anonymous && !(rule.parameter = value(clause.parameter, env))) return false;
    const Folded folded = fold(scene_, rule, values);
    const bool undefined = inner.failed_ || folded.failed;
    failed_ = failed_ || undefined;
    if (undefined || !folded.value) return false;
    const Mark mark(*this, env);
    std::optional<Value>& variable = env[clause.variable.index()];
    if (variable && *variable != *folded.value) return false;
    if (!variable) bind(clause.variable.index(), *folded.value, env);
    return step(std::move(rest), env, found);
}

bool Solver::finish(const Clauses& negations, Environment& env, const Found& found) {
    for (const Deferred& d : deferred_) {
        const std::optional<Value> is = value(*d.term, env);
        if (!is || *is != d.value) return false;
    }
    for (const Clause* c : negations)
        if (c->kind != Clause::Kind::Not || !nothing_satisfies(c->inner, env)) return false;
    return found();
}

// A negation sees all facts, those too that the rule is about to consume.
bool Solver::nothing_satisfies(const std::vector<Clause>& inner, Environment& env) {
    Solver solver(sight_);
    solver.inside_ = true;
    const bool any = solver.solve(inner, env, [] { return true; });
    failed_ = failed_ || solver.failed_;
    return !any && !solver.failed_;
}

// ---- matching

bool Solver::match(const Atom& atom, const Row& row, Environment& env) {
    for (std::size_t i = 0; i < row.size(); ++i)
        if (!unify(atom.arguments[i], row[i], env)) return false;
    return true;
}

// Makes the term equal to the value, by binding what is not bound, part by part.
bool Solver::unify(const Term& t, const Value& is, Environment& env) {
    if (t.op == Op::Anonymous) return true;
    if (t.is_variable() && !env[t.variable.index()]) {
        if (!is_finite(is)) {
            failed_ = true;
            return false;
        }
        bind(t.variable.index(), is, env);
        return true;
    }
    if (all_bound(t, env) && !is_pattern(t)) {
        const std::optional<Value> own = value(t, env);
        return own && *own == is;
    }
    if (!is_pattern(t)) {
        deferred_.push_back({&t, is});
        return true;
    }
    const Values& items = is.items();
    if (t.op == Op::Cons)
        return !items.empty() && unify(t.operands[0], items[0], env) &&
               unify(t.operands[1], value_of(Values(items.begin() + 1, items.end())), env);
    if (t.operands.size() != items.size()) return false;
    for (std::size_t i = 0; i < items.size(); ++i)
        if (!unify(t.operands[i], items[i], env)) return false;
    return true;
}

void Solver::bind(std::size_t variable, const Value& is, Environment& env) {
    env[variable] = is;
    bound_.push_back(variable);
}

std::optional<Value> Solver::value(const Term& term, const Environment& env) {
    std::optional<Value> result = evaluate(scene_, term, env);
    failed_ = failed_ || !result;
    return result;
}

std::vector<Row> Solver::candidates(const Atom& atom, const Environment& env) const {
    const check::Predicate& p = program_.predicates[atom.predicate];
    const std::optional<Value> place = env[atom.arguments[0].variable.index()];
    if (sight_.rows) return sight_.rows(atom, place);
    if (is_neighbor(p)) return linked(atom, place, env);
    const std::size_t index = atom.predicate.index();
    std::vector<Row> rows;
    if (p.linear()) {
        const auto [first, last] = at_catom((*linear_)[index], place->integer());
        rows.assign(first, last);
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
    const bool from_here =
        atom.arguments[0].variable == sight_.site || (atom.arguments[1].is_variable() && atom.arguments[1].variable == sight_.site);
    const Links& links = sight_.links_before == nullptr || from_here ? scene_.links : *sight_.links_before;
    if (place) {
        if (const auto found = links.find(place->integer()); found != links.end())
            for (const Link& link : found->second) add(place->integer(), link.other, link.port);
        // What a neighbour sends are facts like all others.
        if (!from_here) std::sort(rows.begin(), rows.end());
        return rows;
    }
    const Term& end = atom.arguments[1];
    const Value* other = end.is_variable() && env[end.variable.index()] ? &*env[end.variable.index()] : nullptr;
    for (const auto& [catom, its] : links) {
        if (other != nullptr && other->integer() != catom) continue;
        for (const Link& link : its) add(link.other, catom, link.back);
    }
    return rows;
}

}  // namespace meld::reference
